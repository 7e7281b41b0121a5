"""A simulated device on a real serial port: a pseudo-terminal, which POSIX systems have."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import threading

from sim_hardware.serial_devices.contract import SerialDevice
from sim_hardware.serial_devices.wire import SerialFaults, Wire

_POLL_S = 0.005


def _open() -> tuple[int, int, str]:
    """Return both ends of a new line, and what a serial library opens it by."""
    if sys.platform != "win32":
        import pty
        import tty

        ours, theirs = pty.openpty()
        tty.setraw(theirs)
        os.set_blocking(ours, False)
        return ours, theirs, os.ttyname(theirs)
    raise OSError(
        "simulated serial ports need pseudo-terminals, which this system does not have: "
        "use `simulated` as the device's address instead"
    )


class PtyPort:
    """Serves a device at `path`, which any serial library opens, until `stop`."""

    def __init__(self, device: SerialDevice, faults: SerialFaults | None = None) -> None:
        self._wire = Wire(device, faults)
        # This end of the line is kept open too: between two clients it must not look unplugged.
        self._ours, self._theirs, self.path = _open()
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="serial-device", daemon=True)
        self._thread.start()

    @property
    def faults(self) -> SerialFaults:
        """The faults of the cable; `unplugged` takes the port away for good."""
        return self._wire.faults

    def stop(self) -> None:
        """Take the port away. May be called twice."""
        self._ending.set()
        self._thread.join(timeout=5)

    def _serve(self) -> None:
        try:
            while not self._ending.is_set() and not self.faults.unplugged:
                ready, _, _ = select.select([self._ours], [], [], _POLL_S)
                self._send(self._wire.poll())
                if ready:
                    self._send(self._wire.respond(os.read(self._ours, 4096)))
        except Exception as fault:  # noqa: BLE001 - the device may be another distribution's
            sys.stderr.write(f"{self.path} is gone: {self._wire.why(fault)}\n")
        finally:
            os.close(self._theirs)
            os.close(self._ours)

    def _send(self, data: bytes) -> None:
        # No client reads and the line's buffer is full: a device without flow control continues
        # to send, and its bytes are lost.
        with contextlib.suppress(BlockingIOError):
            if data:
                os.write(self._ours, data)

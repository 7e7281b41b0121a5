"""What is done to a running `labrig run`, and where its connections go through for it."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import threading
from contextlib import suppress
from enum import StrEnum

_BACKLOG = 16
_PIECE = 65536


class Fault(StrEnum):
    """The ways to end a run that nobody asked for."""

    KILL = "kill"  # SIGKILL of the program
    KILL_GROUP = "kill group"  # of its process group, as closing a terminal hard does
    HANG = "hang"  # SIGSTOP, and SIGCONT when it is over
    CUT = "cut"  # its connection to the boards is closed, and cannot be made again
    MUTE = "mute"  # nothing passes on its connection any more, which stays open
    JERK = "jerk"  # all connections to the boards are closed once; new ones are taken

    @property
    def is_deadly(self) -> bool:
        """Whether the program is dead at once."""
        return self in (Fault.KILL, Fault.KILL_GROUP)

    @property
    def needs_relay(self) -> bool:
        """Whether it happens to a connection."""
        return self in (Fault.CUT, Fault.MUTE, Fault.JERK)


def do(fault: Fault, process: subprocess.Popen[bytes], relay: Relay | None) -> None:
    """Do it, now."""
    if fault is Fault.KILL:
        process.kill()
    elif fault is Fault.KILL_GROUP:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    elif fault is Fault.HANG:
        process.send_signal(signal.SIGSTOP)
    elif relay is not None:
        {Fault.CUT: relay.cut_first, Fault.MUTE: relay.mute_first, Fault.JERK: relay.cut_all}[
            fault
        ]()


class _Link:
    """One connection, passed on in both directions by a thread each."""

    def __init__(self, client: socket.socket, server: socket.socket) -> None:
        self._ends = (client, server)
        self.mute = False
        for source, target in ((client, server), (server, client)):
            threading.Thread(target=self._pump, args=(source, target), daemon=True).start()

    def close(self) -> None:
        """Both ends learn of it at once."""
        for end in self._ends:
            with suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()

    def _pump(self, source: socket.socket, target: socket.socket) -> None:
        with suppress(OSError):
            while piece := source.recv(_PIECE):
                if not self.mute:
                    target.sendall(piece)
        if not self.mute:
            self.close()


class Relay:
    """A port that stands for the boards' port; the first who connects is the program itself.

    The guard connects after it, so that a fault of the program's own connection leaves the guard's
    as it is.
    """

    def __init__(self, target: str) -> None:
        host, _, port = target.rpartition(":")
        self._target = (host, int(port))
        self._listener = socket.create_server(("127.0.0.1", 0), backlog=_BACKLOG)
        self._links: list[_Link] = []
        self._refuses = False
        self.address = f"127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._accept, name="relay", daemon=True).start()

    def cut_first(self) -> None:
        """Close the program's connection and refuse further ones."""
        self._refuses = True
        for link in self._links[:1]:
            link.close()

    def mute_first(self) -> None:
        """Swallow all that comes on the program's connection; refuse further ones."""
        self._refuses = True
        for link in self._links[:1]:
            link.mute = True

    def cut_all(self) -> None:
        """Close every connection; new ones are taken."""
        for link in list(self._links):
            link.close()

    def close(self) -> None:
        """End it."""
        self._refuses = True
        with suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
        for link in self._links:
            link.mute = False
            link.close()

    def _accept(self) -> None:
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            try:
                if self._refuses:
                    raise ConnectionRefusedError
                server = socket.create_connection(self._target)
                for end in (client, server):
                    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._links.append(_Link(client, server))
            except OSError:
                client.close()

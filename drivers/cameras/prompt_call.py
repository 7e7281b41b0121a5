"""A call into a vendor's library that the experiment must not wait for.

A camera that is gone makes its library try again for seconds; the working loop may wait 50 ms.
"""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable

from drivers.interfaces import DeviceError, DeviceTimeoutError, in_words

_PATIENCE_S = 0.04
_CALL, _END = "call", "end"


class PromptCall:
    """A thread that makes the call when asked to. `what`: the call, in words for a sentence."""

    def __init__(self, call: Callable[[], None], what: str) -> None:
        self._call = call
        self._what = what
        self._orders: queue.Queue[str] = queue.Queue(maxsize=1)
        self._answers: queue.Queue[str] = queue.Queue()
        self._awaited = False
        threading.Thread(target=self._work, name=what, daemon=True).start()

    def __call__(self) -> None:
        """Make the call. Raises DeviceError, DeviceTimeoutError after 40 ms."""
        if self._awaited:
            self._await(0.0)
        self._orders.put(_CALL)
        self._awaited = True
        self._await(_PATIENCE_S)

    def end(self) -> None:
        """End the thread, as soon as its last call has come back."""
        try:
            self._orders.put(_END, timeout=_PATIENCE_S)
        except queue.Full:
            return  # it hangs in the library, and is a daemon

    def _await(self, patience_s: float) -> None:
        try:
            fault = self._answers.get(timeout=max(patience_s, 1e-3))
        except queue.Empty:
            raise DeviceTimeoutError(
                f"{self._what} was not answered within {_PATIENCE_S * 1e3:.0f} ms; check the "
                "camera's cable and power"
            ) from None
        self._awaited = False
        if fault:
            raise DeviceError(fault)

    def _work(self) -> None:
        while self._orders.get() == _CALL:
            try:
                self._call()
            except BaseException as fault:  # noqa: BLE001 - a thread has nobody to raise to
                self._answers.put(in_words(fault))
            else:
                self._answers.put("")

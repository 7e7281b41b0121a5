"""Find a part whose call does not return: nobody may wait for it, its conformance test neither."""

from __future__ import annotations

import sys
import sysconfig
import threading
import time
from collections.abc import Callable
from contextvars import copy_context
from pathlib import Path
from types import FrameType

from labrig.errors import is_ours

BLOCKS_S = 5.0  # a call that waits for so long blocks
COMPUTES_S = 120.0  # a call that computes may take so long: it may have to be compiled
_LOOK_S = 0.1
_BUSY = 0.1  # share of the time in which a thread that computes has a processor, at least
_LIBRARY = Path(sysconfig.get_paths()["stdlib"])
_PACKAGES = "site-packages"


def returned(faults: Callable[[], list[str]]) -> list[str]:
    """Return what a conformance function returns, or the call of the part that keeps it waiting.

    It is called in a thread of its own, which is left behind where a call does not return.
    """
    found: list[list[str]] = []
    raised: list[BaseException] = []

    def work() -> None:
        try:
            found.append(faults())
        except BaseException as error:  # noqa: BLE001 - raised again, where it is waited for
            raised.append(error)

    thread = threading.Thread(target=copy_context().run, args=(work,), daemon=True)
    thread.start()
    watch = _Watch()
    while thread.is_alive():
        thread.join(_LOOK_S)
        if said := watch.fault(sys._current_frames().get(thread.ident or 0)):
            return [said]
    if raised:
        raise raised[0]
    return found[0]


class _Watch:
    """Knows which call of the part is on, and since when."""

    def __init__(self) -> None:
        self._call: FrameType | None = None
        self._since_s = self._busy_s = 0.0

    def fault(self, innermost: FrameType | None) -> str:
        """Return a sentence where the call that is on has been for too long; else nothing."""
        call = _outermost_of_the_part(innermost)
        now_s, busy_s = time.monotonic(), time.process_time()
        if call is None or call is not self._call:
            self._call, self._since_s, self._busy_s = call, now_s, busy_s
            return ""
        for_s, computed_s = now_s - self._since_s, busy_s - self._busy_s
        limit_s = BLOCKS_S if computed_s < _BUSY * for_s else COMPUTES_S
        if for_s < limit_s:
            return ""
        place = f"{Path(call.f_code.co_filename).name}, line {call.f_lineno}"
        return f"its {call.f_code.co_name} has not returned in {limit_s:g} s: it blocks ({place})"


def _outermost_of_the_part(frame: FrameType | None) -> FrameType | None:
    """Return the frame by which our code has called that of the part; None: it has not."""
    found = None
    while frame is not None:
        if not is_ours(frame.f_globals.get("__name__", "")) and not _in_library(frame):
            found = frame
        frame = frame.f_back
    return found


def _in_library(frame: FrameType) -> bool:
    """Whether it is code of Python itself, such as an import or a thread's beginning."""
    file = Path(frame.f_code.co_filename)
    of_python = file.is_relative_to(_LIBRARY) and _PACKAGES not in file.parts
    return of_python or file.name.startswith("<frozen")

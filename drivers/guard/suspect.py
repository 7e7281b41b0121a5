"""What has hung when no heartbeat comes: the program, its connection, the boards or their driver.

A thread of the program looks at the stack of the working loop while that does not beat, and sends
a life sign that says where the loop is. The guard adds whether the boards answer its own
connection.
"""

from __future__ import annotations

import sys
from types import FrameType

from drivers.boards.contract import DEFAULT

# Life signs, one byte each, of a program whose working loop does not beat.
IN_THE_PROGRAM, AT_THE_BOARDS, AT_A_DEVICE = b"p", b"b", b"d"
SIGNS = frozenset({IN_THE_PROGRAM, AT_THE_BOARDS, AT_A_DEVICE})

_BOARDS = ("drivers.boards.", "drivers.amplifier", "drivers.safe_shutdown")  # of the boards only
_NO_DEVICE = ("drivers.interfaces", "drivers.guard")


def sign_of(thread: int) -> bytes:
    """Return the life sign of a thread: what its innermost call into a driver is for."""
    frame: FrameType | None = sys._current_frames().get(thread)
    while frame is not None:
        module = str(frame.f_globals.get("__name__", ""))
        if module.startswith(_BOARDS):
            return AT_THE_BOARDS
        if module.startswith("drivers.") and not module.startswith(_NO_DEVICE):
            return AT_A_DEVICE
        frame = frame.f_back
    return IN_THE_PROGRAM


def what_hangs(sign: bytes | None, boards: str, address: str, *, boards_answer: bool) -> str:
    """Return in words what has hung, as far as can be told.

    `sign`: the newest life sign; None: the program has given none. `boards`: the kind of
    their family. `address`: theirs. `boards_answer`: whether they answered the guard at once.
    """
    if sign not in (AT_A_DEVICE, AT_THE_BOARDS):
        return "the program hangs"
    if address in ("", "local"):
        server = "the boards' driver"
    elif boards == DEFAULT:
        server = f"the device server at {address}"
    else:
        server = f"{boards} at {address}"
    if sign == AT_A_DEVICE and boards_answer:
        return "a device other than the boards does not answer the program"
    if sign == AT_A_DEVICE:
        return f"{server} and another device do not answer"
    if not boards_answer:
        return f"{server} does not answer"
    if address in ("", "local"):
        return f"{server} does not return to the program; it answers the guard"
    return f"the program's connection to {server} hangs; the guard's own one works"

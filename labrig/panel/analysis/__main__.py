"""An analysis process: read the order, do it, report progress and outcome as lines of JSON.

It ends with its input, so that nothing computes on when the panel has gone.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from typing import TextIO

from labrig.errors import LabrigError
from labrig.garbage import look_for_garbage_seldom
from labrig.left_out import listen, told_of
from labrig.panel.analysis.order import AnalysisOrder
from labrig.panel.analysis.work import WORK
from labrig.panel.processes import be_ended_first, end_with_children
from labrig.serialise import finite


class Messages:
    """Lines of JSON to the panel."""

    def __init__(self, sink: TextIO) -> None:
        self._sink = sink
        self._lock = threading.Lock()

    def send(self, kind: str, **fields: object) -> None:
        """Send one message."""
        line = json.dumps(finite({"type": kind, **fields}), allow_nan=False)
        with self._lock:
            self._sink.write(line + "\n")
            self._sink.flush()

    def progress(self, fraction: float, step: str) -> None:
        """Report how far the work is."""
        self.send("progress", fraction=round(fraction, 4), step=step)


def main() -> None:
    """Read the order and do it."""
    be_ended_first()
    look_for_garbage_seldom()
    messages = Messages(_own_output())
    text = sys.stdin.readline()
    listen()
    try:
        with told_of(lambda said: messages.send("left_out", text=said)):
            _do(AnalysisOrder.from_json(text), messages)
    except BaseException as error:  # noqa: BLE001 - the panel must learn of it
        messages.send("failed", message=sentence_of(error))


def _do(order: AnalysisOrder, messages: Messages) -> None:
    if order.kind == "live":
        from labrig.panel.analysis.live_process import follow

        follow(order, sys.stdin, messages)
        return
    threading.Thread(target=_end_with_input, name="panel-watch", daemon=True).start()
    done = WORK[order.kind](order, messages.progress)
    messages.send("done", message=done.message, files=done.files, notes=done.notes)


def sentence_of(error: BaseException) -> str:
    """Return the sentence for the user; what should not have happened is logged in full."""
    from model import ModelError

    if isinstance(error, LabrigError):
        return str(error)
    if isinstance(error, ModelError):
        return f"{str(error).rstrip('.')}."
    import traceback

    traceback.print_exc()  # into the panel's analysis.log
    if isinstance(error, MemoryError):
        return "there is not enough memory for this; close other programs and try again."
    text = " ".join(str(error).split())
    return (
        f"this should not have happened ({type(error).__name__}: {text}); please report it with "
        ".labrig/analysis.log of the data folder."
    )


def _own_output() -> TextIO:
    """Return the panel's pipe; whatever a library prints goes to the log instead."""
    own = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    return own


def _end_with_input() -> None:
    sys.stdin.read()
    end_with_children(os.getpid())


if __name__ == "__main__":
    main()

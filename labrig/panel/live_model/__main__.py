"""Follow runs with a dynamic model, in a process: `python -m labrig.panel.live_model`.

Batches come in, each with messages, a piece of the signals and a curve; each has its answer.
It ends with its input. It may be late and it may die: nothing waits for it but its own thread.
"""

from __future__ import annotations

import sys
from contextlib import suppress

from labrig.garbage import look_for_garbage_seldom
from labrig.panel.live.event_stream import Message
from labrig.panel.live.packing import BrokenConnectionError, Header, pack, read, write
from labrig.panel.live.strip_chart import StripChart, strip_from
from labrig.panel.live_model.beside_run import ModelBesideRun
from labrig.panel.processes import be_ended_first


def answered(model: ModelBesideRun, batch: Header, payload: memoryview) -> bytes:
    """Return the answer to a batch, packed."""
    for message in batch["messages"]:
        _take(model, message)
    strip: StripChart | None = None
    if batch.get("strip") is not None:
        strip = strip_from(batch["strip"], payload)
    answer = model.follow(strip, batch.get("curve"))
    header: Header = {"motion": answer.motion, "estimates": answer.estimates}
    if answer.strip is None:
        return pack(header)
    header["strip"] = answer.strip.header()
    return pack(header, answer.strip.values.astype("<f4").tobytes())


def _take(model: ModelBesideRun, message: Message) -> None:
    if message["type"] == "model":
        model.choose(message["path"])
    elif message["type"] == "setup":
        model.setup(message)
    else:
        model.take(message)


def main() -> None:
    """Serve until the input ends."""
    be_ended_first()
    look_for_garbage_seldom()
    model = ModelBesideRun()
    source, sink = sys.stdin.buffer, sys.stdout.buffer
    with suppress(BrokenConnectionError, OSError, KeyboardInterrupt):
        while True:
            batch, payload = read(source)
            write(sink, answered(model, batch, payload))


if __name__ == "__main__":
    main()

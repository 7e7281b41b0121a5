"""Kills of the operator's computer, with `labrig watch` at the boards: seconds until 0 V.

    python -m benchmarks.watch_kills --kills 200

`killed`: run and guard together (kill -9). `reboot`: both stand still at once and are never heard
again. `network gone`: every byte between the computers vanishes, and no end is told. Linux.
Beside each stands how late a thread of this program woke meanwhile: where the computer stood still
for that long, so may have the boards' server, the world's record or the watch.
"""

from __future__ import annotations

import argparse
import tempfile
import threading
import time
from collections.abc import Iterator
from itertools import cycle
from pathlib import Path

from tests.end_to_end.watched_rig import watched

KINDS = {"killed": "killed", "reboot": "stopped", "network gone": "network gone"}
WITHIN_S, ROW_S = 1.0, 0.02  # the promise, and the distance of rows of the world's record


_LOOK_S = 0.005
PER_RIG = 30  # kills that one served rig takes; then another is started


class StallMeter:
    """How late a thread wakes that only sleeps."""

    def __init__(self) -> None:
        self._worst_s = 0.0
        threading.Thread(target=self._look, daemon=True).start()

    def worst_s(self) -> float:
        """The latest since this was asked last."""
        worst_s, self._worst_s = self._worst_s, 0.0
        return worst_s

    def _look(self) -> None:
        while True:
            began_s = time.monotonic()
            time.sleep(_LOOK_S)  # noqa: TID251 - it measures the computer
            self._worst_s = max(self._worst_s, time.monotonic() - began_s - _LOOK_S)


def kills(count: int) -> Iterator[tuple[str, float, float]]:
    """Yield what happened, the seconds until 0 V, and the stall: the kinds in turns."""
    meter = StallMeter()
    kinds = [kind for kind, _ in zip(cycle(KINDS), range(count), strict=False)]
    for begin in range(0, count, PER_RIG):
        with tempfile.TemporaryDirectory() as folder, watched(Path(folder)) as rig:
            for kind in kinds[begin : begin + PER_RIG]:
                took_s = rig.zeroed_after(KINDS[kind], before=meter.worst_s)
                stall_s = meter.worst_s()
                rig.hear("the output is safe: 0 V written and read back")
                rig.mend()
                yield kind, took_s, stall_s


def main() -> None:
    """Print a line for each kill, and the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200)
    found: dict[str, list[float]] = {kind: [] for kind in KINDS}
    for number, (kind, took_s, stall_s) in enumerate(kills(parser.parse_args().kills), start=1):
        found[kind].append(took_s)
        print(f"{number:4} {kind:12} {took_s:.3f} s, stall {stall_s:.3f} s", flush=True)
    for kind, took in found.items():
        if took:
            good = sum(each <= WITHIN_S + ROW_S for each in took)
            print(f"{kind}: {good} of {len(took)} within {WITHIN_S:g} s, longest {max(took):.3f} s")


if __name__ == "__main__":
    main()

"""Kills of the operator's computer, with `labrig watch` at the boards: seconds until 0 V.

    python -m benchmarks.watch_kills --kills 200

`killed`: run and guard together (kill -9). `reboot`: both stand still at once and are never heard
again. `network gone`: every byte between the computers vanishes, and no end is told. Linux.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from itertools import cycle
from pathlib import Path

from tests.end_to_end.watched_rig import watched

KINDS = {"killed": "killed", "reboot": "stopped", "network gone": "network gone"}
WITHIN_S, ROW_S = 1.0, 0.02  # the promise, and the distance of rows of the world's record


PER_RIG = 30  # kills that one served rig takes; then another is started


def kills(count: int) -> Iterator[tuple[str, float]]:
    """Yield what happened, and the seconds until 0 V: the kinds in turns."""
    kinds = [kind for kind, _ in zip(cycle(KINDS), range(count), strict=False)]
    for begin in range(0, count, PER_RIG):
        with tempfile.TemporaryDirectory() as folder, watched(Path(folder)) as rig:
            for kind in kinds[begin : begin + PER_RIG]:
                took_s = rig.zeroed_after(KINDS[kind])
                rig.hear("the output is safe: 0 V written and read back")
                rig.mend()
                yield kind, took_s


def main() -> None:
    """Print a line for each kill, and the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=200)
    found: dict[str, list[float]] = {kind: [] for kind in KINDS}
    for number, (kind, took_s) in enumerate(kills(parser.parse_args().kills), start=1):
        found[kind].append(took_s)
        print(f"{number:4} {kind:12} {took_s:.3f} s", flush=True)
    for kind, took in found.items():
        if took:
            good = sum(each <= WITHIN_S + ROW_S for each in took)
            print(f"{kind}: {good} of {len(took)} within {WITHIN_S:g} s, longest {max(took):.3f} s")


if __name__ == "__main__":
    main()

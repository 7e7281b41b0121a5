"""How often intervals of the moving sheet's parameters hold the truth of an independent world.

python -m benchmarks.dynamic_coverage --count 400 --seed 5000 --workers 2 --resume all.jsonl
python -m benchmarks.dynamic_coverage --score all.jsonl
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import argparse
import json
import os
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks._batched import done
from benchmarks.dynamic_coverage.score import FEW_LINKS, LINKS, scored, summary


def read(path: Path) -> list[dict[str, Any]]:
    """Rows that are there; a line that was broken off is none."""
    rows = []
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
        try:
            rows.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return rows


def _lost(seed: int, error: BaseException) -> dict[str, Any]:
    raise RuntimeError(f"seed {seed}: {error}") from error


def collect(path: Path, seeds: Iterable[int], workers: int, links: int) -> list[dict[str, Any]]:
    """Score the sessions that are not yet in the file, writing each down when it is finished."""
    there = {row["seed"] for row in read(path)}
    todo = [seed for seed in seeds if seed not in there]
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as file:
        for row in done(todo, workers, partial(scored, links=links), _lost):
            file.write(json.dumps(row) + "\n")
            file.flush()
    wanted = set(seeds)
    return [row for row in read(path) if row["seed"] in wanted]


def main() -> None:
    parser = argparse.ArgumentParser(prog="dynamic_coverage", description=__doc__)
    parser.add_argument("--count", type=int, default=400, help="sessions")
    parser.add_argument("--seed", type=int, default=5000, help="of the first")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument(
        "--links", type=int, default=LINKS,
        help=f"of the world's chain; {FEW_LINKS}: as shipped (its own error is larger)",
    )  # fmt: skip
    parser.add_argument("--resume", type=Path, metavar="FILE", help="keep results here, and go on")
    parser.add_argument("--score", type=Path, metavar="FILE", help="only count what is in a file")
    chosen = parser.parse_args()
    if chosen.score:
        rows = read(chosen.score)
    else:
        seeds = range(chosen.seed, chosen.seed + chosen.count)
        path = chosen.resume or Path(__file__).parents[1] / "results" / "dynamic_coverage.jsonl"
        rows = collect(path, seeds, chosen.workers, chosen.links)
    print(summary(rows).text())


if __name__ == "__main__":
    main()

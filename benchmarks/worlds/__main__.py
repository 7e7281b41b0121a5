"""Hide something in the sessions of worlds that share nothing with the model, and ask methods.

python -m benchmarks.worlds --worlds chain --cases 20 --seed 3 --jobs 2 -o records.jsonl
python -m benchmarks.worlds --worlds chain --methods diagnose stlsq -o records.jsonl
python -m benchmarks.worlds --score records.jsonl     # the tables of what is there; nothing is run
python -m benchmarks.worlds --faults chain            # where a generator breaks the contract
python -m benchmarks.worlds --digest splines          # for sealed.toml

Families: nothing (the base model with noise), single (one effect of the catalogue, d 8 - 120), pair
(two of them), outside (d >= 30, in no catalogue); catalogue_form, where asked for (single effects
in the catalogue's own form: for the intervals of parameters). d is the length of what the base
model cannot take up, in standard deviations. A run that is broken off (Ctrl-C) goes on with the
same -o FILE.
A sealed world is refused where its digest is not that of sealed.toml, or its seed is not one of
those to be reported. How to enter a generator or a method: docs/howto/worlds.md.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: a process is a core here

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from benchmarks.hidden_effects import records as kept
from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.run import ROOT
from benchmarks.hidden_effects.score import by_parameter, failures, table
from benchmarks.worlds.base_parameters import by_quantity
from benchmarks.worlds.cases import FAMILIES, SHARES, Task, tasks
from benchmarks.worlds.conformance import faults
from benchmarks.worlds.registry import digest, names
from benchmarks.worlds.run import key, method, methods, run
from benchmarks.worlds.sealed import check, open_worlds
from benchmarks.worlds.table import compared, rows

RESULTS = ROOT / "benchmarks" / "results" / "worlds.jsonl"


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the arguments ask for; 2 where they cannot be."""
    chosen = _arguments(arguments)
    try:
        if chosen.faults is not None:
            return _told(faults(chosen.faults))
        if chosen.digest is not None:
            return _told([digest(chosen.digest)], 0)
        if chosen.score is None:
            _run(chosen)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"broken off; go on with -o {chosen.output}", file=sys.stderr)
        return 130
    _show(kept.load(chosen.score or chosen.output), failed=chosen.failures)
    return 0


def _arguments(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.worlds", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("--worlds", nargs="+", metavar="NAME", help="default: all that are open")
    parser.add_argument(
        "--methods", nargs="+", metavar="NAME", default=["diagnose"],
        help=f"of {', '.join(methods())} (default: diagnose)",
    )  # fmt: skip
    parser.add_argument("--family", nargs="+", choices=FAMILIES, default=list(SHARES))
    parser.add_argument("--cases", type=int, default=100, help="of each world (default: 100)")
    parser.add_argument("--seed", type=int, default=0, help="other cases of the same kind")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default: 2)")
    parser.add_argument(
        "--left-out", action="store_true", help="ask again without one position, and compare there"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", default=RESULTS,
        help="keep a line of JSON for each record here, and go on",
    )  # fmt: skip
    parser.add_argument("--failures", action="store_true", help="tell the cases that fail, too")
    parser.add_argument("--score", type=Path, metavar="FILE", help="only score what is here")
    parser.add_argument("--faults", metavar="NAME", help="only check a generator")
    parser.add_argument("--digest", metavar="NAME", help="only print a generator's sha256")
    return parser.parse_args(arguments)


def _told(lines: Sequence[str], code: int | None = None) -> int:
    print("\n".join(lines) or "no faults")
    return int(bool(lines)) if code is None else code


def _run(chosen: argparse.Namespace) -> None:
    for name in chosen.methods:
        method(name)
    done = {r.key for r in kept.load(chosen.output)}
    todo: list[Task] = []
    for name in chosen.worlds or open_worlds():
        if name not in names():
            raise ValueError(f"there is no generator '{name}'; there are {', '.join(names())}")
        check(name, chosen.seed)
        for task in tasks(name, chosen.cases, chosen.seed, chosen.family):
            left = tuple(m for m in chosen.methods if key(task, m) not in done)
            if left:
                todo.append(replace(task, methods=left, left_out=chosen.left_out))
    print(f"{len(todo)} cases to do; results in {chosen.output}", file=sys.stderr)
    for i, found in enumerate(run(todo, chosen.jobs), 1):
        kept.append(chosen.output, found)
        for one in found:
            print(f"{i}/{len(todo)} {_line(one)}", file=sys.stderr, flush=True)


def _line(r: Record) -> str:
    truth = ", ".join(f"{t.form} ({t.effect}) d {t.d:.0f}" for t in r.truth) or "nothing"
    said = " + ".join([*r.said, *([f"unknown: {r.unknown.slot}"] if r.unknown else [])])
    ratio = "" if r.foretold is None else f", predicted {r.foretold.ratio:.2f}"
    return f"{r.key}  {truth}  ->  {r.error or said or 'nothing'}{ratio}  ({r.cpu_s:.1f} s)"


def _show(records: Sequence[Record], *, failed: bool) -> None:
    """Print a table for each world and for all, with the seeds and states of the program."""
    by: dict[str, dict[str, list[Record]]] = {}
    for r in records:
        by.setdefault(r.key.split(":")[0], {}).setdefault(r.method, []).append(r)
    if len(by) > 1:
        for r in records:
            by.setdefault("all worlds", {}).setdefault(r.method, []).append(r)
    for name, own in by.items():
        for asked, found in own.items():
            seeds = sorted({r.key.split(":")[-1].split("/")[0] for r in found}, key=int)
            codes = sorted({r.code for r in found})
            lines = rows(found)
            told = f"seeds {', '.join(seeds)}, program/generator {', '.join(codes)}"
            print(f"\n{name}, {asked}: {len(found)} cases, {told}\n")
            if len({code.split("/")[0] for code in codes}) > 1 or len(codes) > len(by):
                print("CAUTION: more than one state of the program or of the generator\n")
            print(table(lines))
            print("\nintervals by parameter:\n" + (by_parameter(found) or "  none"))
            print("\n".join(f"  {name:45} {some}" for name, some in by_quantity(found)))
            if failed:
                print("\ncases that fail:\n" + (failures(lines, found) or "none"))
        if len(own) > 1:
            print(f"\n{name}, methods side by side\n\n" + compared(own))


if __name__ == "__main__":
    sys.exit(main())

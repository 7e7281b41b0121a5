"""Hide effects in sessions, have them diagnosed, and print how it went.

python -m benchmarks.hidden_effects --quick            # 40 cases, to see that everything works
python -m benchmarks.hidden_effects --jobs 2 --resume all.jsonl --baselines
python -m benchmarks.hidden_effects --score all.jsonl  # the table of what is there, nothing is run

A run that is broken off (Ctrl-C) goes on with the same `--resume FILE`.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: a process is a core here

import argparse
import datetime as dt
import sys
from pathlib import Path

from benchmarks.hidden_effects import records as kept
from benchmarks.hidden_effects.compared import table as compared
from benchmarks.hidden_effects.figures import draw
from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.run import ROOT, Baselines, record, run
from benchmarks.hidden_effects.score import by_parameter, failures, scored, table
from benchmarks.hidden_effects.suite import FULL, nulls_task, tasks

QUICK = 40
RESULTS = ROOT / "benchmarks" / "results"


def main() -> int:
    chosen = _arguments()
    path = chosen.score or chosen.resume or RESULTS / f"hidden_effects_{_now()}.jsonl"
    try:
        if chosen.score is None:
            _run(chosen, path)
    except KeyboardInterrupt:
        print(f"broken off; go on with --resume {path}", file=sys.stderr)
        return 130
    _show(kept.load(path), chosen.figures)
    return 0


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.hidden_effects")
    size = parser.add_mutually_exclusive_group()
    size.add_argument("--quick", action="store_true", help=f"{QUICK} cases")
    size.add_argument("--cases", type=int, help=f"how many (default: {FULL})")
    parser.add_argument("--jobs", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--seed", type=int, default=0, help="another suite of the same kind")
    parser.add_argument("--family", nargs="+", default=[], help="only these families")
    parser.add_argument("--baselines", action="store_true", help="ask simpler methods, too")
    parser.add_argument("--nulls", action="store_true", help="time 500 nulls; a full run does it")
    parser.add_argument("--resume", type=Path, metavar="FILE", help="keep results here, and go on")
    parser.add_argument("--score", type=Path, metavar="FILE", help="only score what is here")
    parser.add_argument("--figures", type=Path, default=RESULTS, metavar="FOLDER")
    return parser.parse_args()


def _run(chosen: argparse.Namespace, path: Path) -> None:
    done = {r.key for r in kept.load(path)}
    count = QUICK if chosen.quick else chosen.cases or FULL
    wanted = tasks(count, chosen.seed)
    if chosen.family:
        wanted = [t for t in wanted if t.family in chosen.family]
    todo = [t for t in wanted if t.key not in done]
    print(f"{len(todo)} cases to do, {len(done)} done; results in {path}", file=sys.stderr)
    for i, one in enumerate(run(todo, chosen.jobs, _baselines(chosen)), 1):
        kept.append(path, [one])
        print(f"{i}/{len(todo)} {_line(one)}", file=sys.stderr, flush=True)
    timed = nulls_task(chosen.seed)
    if (chosen.nulls or not (chosen.quick or chosen.cases)) and timed.key not in done:
        print("one session with 500 nulls", file=sys.stderr)
        kept.append(path, [record(timed)])


def _baselines(chosen: argparse.Namespace) -> Baselines | None:
    if not chosen.baselines:
        return None
    from benchmarks.hidden_effects.baselines import answers

    return answers


def _show(records: list[Record], folder: Path) -> None:
    rows = scored(records)
    codes = sorted({r.code for r in records})
    print(f"\n{len(records)} cases, {_now()}, program {', '.join(codes)}\n")
    if len(codes) > 1:
        print("CAUTION: these cases were judged by more than one state of the program\n")
    print(table(rows))
    print("\nintervals by parameter:\n" + by_parameter(records))
    if any(r.baselines for r in records):
        print("\n" + compared(records))
    print("\ncases that fail:\n" + (failures(rows, records) or "none"))
    for path in draw(records, folder):
        print(path)


def _line(r: Record) -> str:
    truth = ", ".join(f"{t.effect}/{t.form} d {t.d:.0f}" for t in r.truth) or "nothing"
    said = r.error or " + ".join([*r.said, *(["unknown"] if r.unknown else [])]) or "nothing"
    return f"{r.key}  {truth}  ->  {said}  ({r.cpu_s:.1f} s)"


def _now() -> str:
    return dt.datetime.now(tz=dt.UTC).strftime("%Y-%m-%d-%H%M")


if __name__ == "__main__":
    sys.exit(main())

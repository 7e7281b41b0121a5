"""Fit the probabilities and sets of answers that `diagnose` reports, from records of worlds.

python -m benchmarks.worlds --worlds chain shooting elements --cases 100 --seed 500 -o train.jsonl
python -m benchmarks.worlds.calibrate train.jsonl          # writes the file that labrig reads
python -m benchmarks.worlds.calibrate --check other.jsonl  # how its sets do; nothing is fitted

Records are those of `diagnose`, of this state of the program, in worlds that are open.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from benchmarks.hidden_effects import records as kept
from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.score import table
from benchmarks.worlds.fit_answers import COVERAGE, fitted
from benchmarks.worlds.right_answers import labelled
from benchmarks.worlds.sealed import is_sealed
from benchmarks.worlds.sets_table import rows
from model.discrepancy.answers.calibrated_answers import FILE, CalibratedAnswers
from model.discrepancy.answers.calibrated_answers import calibrated as in_use


def main(arguments: Sequence[str] | None = None) -> int:
    """Fit, or check; 2 where the records cannot be used."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.worlds.calibrate", description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("records", nargs="+", type=Path, metavar="RECORDS")
    parser.add_argument("-o", "--output", type=Path, default=FILE, metavar="FILE")
    parser.add_argument("--check", action="store_true", help="only tell how the sets in use do")
    chosen = parser.parse_args(arguments)
    found = [r for path in chosen.records for r in kept.load(path) if r.choice_sets]
    try:
        if not chosen.check:
            _fit(found, chosen.output)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    print(table(rows(found, in_use() if chosen.check else _read(chosen.output))))
    return 0


def _fit(found: Sequence[Record], output: Path) -> None:
    worlds = Counter(r.key.split(":")[0] for r in found)
    if len(worlds) < 2:
        raise ValueError("there are records of fewer than two worlds with choice sets")
    sealed = [name for name in worlds if is_sealed(name)]
    if sealed:
        raise ValueError(f"nothing may be fitted to the sealed world '{sealed[0]}'")
    questions = [q for r in found for q in labelled(r)]
    result = fitted(questions)
    answers = result.answers
    states = {r.code for r in found}
    made = {
        "worlds": dict(sorted(worlds.items())),
        "seeds": sorted({int(r.key.split(":")[-1].split("/")[0]) for r in found}),
        "program": sorted({code.split("/")[0] for code in states}),
        "generators": sorted({code.split("/")[1] for code in states if "/" in code}),
        "coverage": COVERAGE,
        "questions": len(questions),
        "ridge": result.ridge,
        "log_loss_in_other_worlds": round(result.log_loss, 4),
    }
    whole = {
        "made": made,
        "contents": {k: round(v, 6) for k, v in answers.contents.items()},
        "weights": {k: round(v, 6) for k, v in answers.weights.items()},
    }
    output.write_text(json.dumps(whole, indent=2) + "\n", encoding="utf-8")


def _read(file: Path) -> CalibratedAnswers:
    whole = json.loads(file.read_text(encoding="utf-8"))
    return CalibratedAnswers(whole["weights"], whole["contents"])


if __name__ == "__main__":
    sys.exit(main())

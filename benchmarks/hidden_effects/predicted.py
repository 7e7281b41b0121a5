"""How well the model that `diagnose` writes predicts what nobody measured.

    python -m benchmarks.hidden_effects.predicted --cases 200 --seed 7

A session with something hidden is diagnosed, its model written to a file and read back, and
`simulate` asked for 20 conditions that the session does not hold: half-way between its positions,
some between its voltages. The truth is what a rig without noise and scatter measures there. The
errors of force and curve are stated over those of the base model (`labrig fit`), together in units
of what the base model errs by where nothing is hidden. That share is also the `floor`: noise and
scatter of the session's own set-ups leave so much, however well the effect is known.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy: a process is a core here

import argparse
import json
import sys
import time
import tomllib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks._batched import done
from benchmarks.hidden_effects.cases import Case
from benchmarks.hidden_effects.records import Errors, Foretold
from benchmarks.hidden_effects.run import Made, made, options_of
from benchmarks.hidden_effects.score import wilson
from benchmarks.hidden_effects.suite import Task, tasks
from benchmarks.hidden_effects.unmeasured import TrueCondition, unmeasured
from labrig.model_file import model_text
from model import Measurements, SheetModel, predict
from model.discrepancy import diagnose
from model.identification.fit import fit
from model.identification.options import FitOptions
from model.sheet.prediction import Prediction

FAMILIES = ("own_form", "other_form", "realistic", "pair", "outside", "excluded")
LEAST_D = 12.0
GOAL, WORSE_GOAL = 0.3, 0.02


@dataclass(frozen=True, kw_only=True)
class Compared(Foretold):
    """One case: its errors at conditions not measured."""

    key: str
    hidden: str
    said: str
    d: float
    stated: Errors  # what the file says of the measured conditions
    cpu_s: float

    def of(self, which: int) -> float | None:
        """Return the ratio of forces (0) or curves (1); None where the base model errs little."""
        if self.base[which] < 2.0 * self.floor[which]:
            return None
        return self.written[which] / self.base[which]


def errors(model: SheetModel, truth: Sequence[TrueCondition]) -> Errors:
    """Return the RMS errors of force (N) and curve (m); infinite where it says: not reachable."""
    return errors_of(partial(predict, model), truth)


def errors_of(
    foretell: Callable[[str, float, float], Prediction], truth: Sequence[TrueCondition]
) -> Errors:
    """Return the errors of predictions by configuration, position (m) and voltage.

    Curves are compared at equal shares of their lengths: a camera of another scale sees another
    length of the same sheet.
    """
    force, curve = [], []
    for one in truth:
        found = foretell(one.configuration, one.position_m, one.voltage_V)
        if not found.reachable:
            return np.inf, np.inf
        force.append(found.F_N - one.force_N)
        share = one.s_m / one.s_m[-1]
        for at, places in zip(one.points_m.T, (found.x_m, found.y_m), strict=True):
            curve.append(np.interp(share, found.s_m / found.s_m[-1], places) - at)
    both = np.sum(np.square(np.concatenate(curve))) / sum(len(one.s_m) for one in truth)
    return float(np.sqrt(np.mean(np.square(force)))), float(np.sqrt(both))


def read_back(model: SheetModel) -> SheetModel:
    """Return the model as the next command reads it from its file."""
    return SheetModel.from_dict(tomllib.loads(model_text(model)))


def base_model(measurements: Measurements, case: Case) -> SheetModel:
    """Return what `labrig fit` writes."""
    return fit(measurements, FitOptions(symmetric=case.symmetric)).model


@dataclass(frozen=True, kw_only=True)
class Asked:
    """A session with the truth of conditions that it does not hold, and the base model's errors."""

    one: Made
    truth: list[TrueCondition]
    base: Errors
    floor: Errors


def asked(task: Task) -> Asked:
    """Make the session and everything it is compared with."""
    one = made(task)
    case = one.hidden.case
    truth = unmeasured(case)
    return Asked(
        one=one, truth=truth,
        base=errors(base_model(one.hidden.measurements, case), truth),
        floor=errors(base_model(one.bare, case), unmeasured(case.bare)),
    )  # fmt: skip


def compared(asked_: Asked) -> Compared:
    """Diagnose, write, read back, simulate."""
    one, began = asked_.one, time.process_time()
    found = diagnose(one.hidden.measurements, options_of(one.task))
    cpu_s, model = time.process_time() - began, read_back(found.model)
    merit = found.model.merit
    said = [e.name for e in found.effects]
    said += [f"unknown:{found.unknown.location}"] if found.unknown is not None else []
    return Compared(
        key=one.task.key,
        hidden=", ".join(f"{e.effect}/{e.form}" for e in one.hidden.truth.effects),
        said=" + ".join(said), d=min(one.visible.d), base=asked_.base,
        written=errors(model, asked_.truth), floor=asked_.floor,
        stated=(merit.get("force_rmse_N", np.nan), merit.get("curve_rmse_m", np.nan)),
        cpu_s=cpu_s,
    )  # fmt: skip


def answer(task: Task) -> Compared | str:
    """Return one case, or why there is none."""
    try:
        return compared(asked(task))
    except Exception as error:  # noqa: BLE001 - one case less, and it is told
        return f"{task.key}: {type(error).__name__}: {error}"


def wanted(count: int, seed: int, families: Sequence[str] = FAMILIES) -> list[Task]:
    """Return so many cases of the suite in which something is hidden, mixed as there."""
    several = tasks(8 * count, seed)
    return [t for t in several if t.family in families][:count]


def run(todo: Sequence[Task], jobs: int) -> Iterator[Compared | str]:
    """Yield cases as they are done."""
    yield from done(todo, jobs, answer, lambda task, error: f"{task.key}: {error}")


def table(found: Sequence[Compared]) -> str:
    """Return rows of Markdown: all cases with a name or an unknown at d >= 12, and each kind."""
    counted = [c for c in found if c.said and c.d >= LEAST_D]
    kinds: dict[str, Callable[[Compared], bool]] = {
        f"a name or an unknown, d >= {LEAST_D:g}": lambda _: True,
        "of these a name alone": lambda c: "unknown" not in c.said,
        "of these an unknown": lambda c: "unknown" in c.said,
        **{f: lambda c, f=f: c.key.startswith(f) for f in FAMILIES},  # type: ignore[misc]
    }
    lines = [
        "| | cases | median (quartiles) | above 1 | force | curve | floor |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, chosen in kinds.items():
        use = [c for c in counted if chosen(c)]
        if use:
            lines.append(f"| {name} | {len(use)} | {_figures(use)} |")
    return "\n".join(lines)


def _figures(use: Sequence[Compared]) -> str:
    ratios = [c.ratio for c in use]
    low, middle, high = np.percentile(ratios, (25, 50, 75), method="closest_observation")
    worse = sum(r > 1.0 for r in ratios)
    first, last = wilson(worse, len(use))
    parts = []
    for which in (0, 1):
        own = [r for c in use if (r := c.of(which)) is not None]
        parts.append(f"{np.median(own):.2f} of {len(own)}" if own else "-")
    floor = np.median([c.least for c in use])
    return (
        f"{middle:.2f} ({low:.2f} - {high:.2f}) | {worse / len(use):.1%}"
        f" ({first:.1%} - {last:.1%}) | {parts[0]} | {parts[1]} | {floor:.2f}"
    )


def line(c: Compared) -> str:
    """One case in a line."""
    force = " ".join(f"{1e3 * e[0]:.3f}" for e in (c.base, c.written, c.floor, c.stated))
    curve = " ".join(f"{1e3 * e[1]:.3f}" for e in (c.base, c.written, c.floor, c.stated))
    return (
        f"{c.key}  {c.hidden} d {c.d:.0f} -> {c.said or 'nothing'}: {c.ratio:.2f}"
        f" (floor {c.least:.2f}; base, written, floor, stated: {force} mN, {curve} mm;"
        f" {c.cpu_s:.1f} s)"
    )


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.hidden_effects.predicted")
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--family", nargs="+", default=list(FAMILIES), choices=FAMILIES)
    parser.add_argument("--keep", type=Path, metavar="FILE", help="a line of JSON for each case")
    chosen = parser.parse_args()
    found = []
    for one in run(wanted(chosen.cases, chosen.seed, chosen.family), chosen.jobs):
        if isinstance(one, str):
            print(f"failed: {one}", file=sys.stderr)
            continue
        found.append(one)
        print(line(one), file=sys.stderr, flush=True)
        if chosen.keep is not None:
            with chosen.keep.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(one)) + "\n")
    print(table(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())

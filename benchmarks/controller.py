"""A controller at work: steps in the moving world, limits, and what 100 faults in the loop end in.

The designs are of the sheets of the examples at 200 Hz with 3 ms of delay. The faults come at
random moments of a controlled run on the simulated rig, at the wire: boards, load cell, camera and
time. Each piece is kept when it is made: `python -m benchmarks.controller --seconds 300` begins
none after so long, and the next call goes on.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import asdict, fields
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks._loop_faults import LIMIT_V as BOARD_LIMIT_V
from benchmarks._loop_faults import LONGEST_S, Ended, Fault, random_faults, run_with
from benchmarks._loop_step import RATE_HZ, Steps, goal, steps
from benchmarks._pieces import Piece, Pieces
from benchmarks.hidden_effects.score import wilson
from benchmarks.report import Report, Table, busy
from labrig.control.sheet_loop import design_loop, linear_sheet
from labrig.model_file import save_model
from model.dynamics.linear.feedback import Method
from model.dynamics.linear.loop_design import StepFigures
from tests.labrig.moving_model import model

FAULTS, SEED = 100, 7
WORLDS = range(31, 37)  # seeds
LONGEST_UNDER_VOLTAGE_S = 30.0  # [limits] of the shipped rig
METHODS: tuple[Method, ...] = ("pi", "lqg")
SHEETS = (("long", 0.0), ("long", 15.0), ("short", 5.0))  # configuration, position in mm
Row = tuple[str, ...]


def measure() -> Report:
    """Run it to its end."""
    return report(Pieces("controller"))


def report(pieces: Pieces) -> Report:
    """Return all that is known once the time of `pieces` is over."""
    note = busy()
    designs = {
        f"{name}, {at_mm:g} mm, {method}": partial(_design, name, at_mm, method)
        for name, at_mm in SHEETS
        for method in METHODS
    }
    runs = {
        f"{method} {seed}": partial(_step_piece, method, seed)
        for seed in WORLDS
        for method in METHODS
    }
    faults = {
        f"fault {k}": partial(_fault_piece, fault)
        for k, fault in enumerate(random_faults(FAULTS, SEED))
    }
    made = _known(pieces, designs)
    found = _known(pieces, _in_turns(runs, faults))
    moved = {name: _steps_of(piece) for name, piece in found.items() if name in runs}
    ended = [Ended(**piece) for name, piece in found.items() if name in faults]
    figures = {
        "designs": made,
        "steps": {name: asdict(one) for name, one in moved.items()},
        "faults": [asdict(one) for one in ended],
    }
    notes = (*_missing(len(moved), len(ended)), *_fault_notes(ended), *_limit_notes(moved, ended))
    tables = (_designs(made), *_moved(moved), _faults(ended))
    return Report(tables, figures, (*notes, note))


def _in_turns(*groups: dict[str, partial[Piece]]) -> dict[str, partial[Piece]]:
    """Return the pieces of all groups, each group's spread evenly over the whole."""
    placed = [
        ((k + 0.5) / len(group), name, make)
        for group in groups
        for k, (name, make) in enumerate(group.items())
    ]
    return {name: make for _, name, make in sorted(placed, key=lambda one: one[0])}


def _known(pieces: Pieces, wanted: dict[str, partial[Piece]]) -> dict[str, Piece]:
    found = {name: pieces.result(name, make) for name, make in wanted.items()}
    return {name: piece for name, piece in found.items() if piece is not None}


def _design(name: str, position_mm: float, method: Method) -> Piece:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "model.toml"
        save_model(model(names=("long", "short")), path)
        made = design_loop(linear_sheet(path, name, 1e-3 * position_mm), goal(method), path)
    return {"sensitivity_peak": made.sensitivity_peak} | asdict(made.step)


def _step_piece(method: Method, seed: int) -> Piece:
    return asdict(steps(method, seed))


def _fault_piece(fault: Fault) -> Piece:
    return asdict(run_with(fault))


def _steps_of(piece: Piece) -> Steps:
    figures = {name: StepFigures(**piece[name]) for name in ("predicted", "found")}
    rest = {f.name: piece[f.name] for f in fields(Steps) if f.name not in figures}
    return Steps(**figures, **rest)


def _missing(steps_made: int, faults_made: int) -> Iterator[str]:
    wanted = len(WORLDS) * len(METHODS) + FAULTS
    if steps_made + faults_made < wanted:
        yield f"NOT COMPLETE: {steps_made + faults_made} of {wanted} runs; run it again to go on"


def _fault_notes(ended: list[Ended]) -> Iterator[str]:
    for kind, words in (
        (True, "faults ended at 0 V, read back, with code 5"),
        (False, "faults that nobody can make safe ended with code 6, and UNKNOWN was said"),
    ):
        of_kind = [each for each in ended if each.can_be_made_safe is kind]
        right = sum(each.is_right for each in of_kind)
        yield f"{right} of {len(of_kind)} {words} (seed {SEED})"
    yield f"boards that answer again refuse for up to 0.8 s, or hang for up to {LONGEST_S:g} s"
    yield from (
        f"WRONG: {each.name} ended with {each.code}, {each.output}, {each.board_V:g} V"
        for each in ended
        if not each.is_right
    )


def _limit_notes(moved: dict[str, Steps], ended: list[Ended]) -> Iterator[str]:
    runs: list[Any] = [*moved.values(), *ended]
    if runs:
        yield (
            f"highest voltage of {len(runs)} runs: {10 * max(r.highest_V for r in runs):.4g} V at "
            f"the sheet (limit {10 * BOARD_LIMIT_V:g} V)"
        )
    longest_s = max((r.under_voltage_s for r in runs if getattr(r, "can_be_made_safe", True)),
                    default=0.0)  # fmt: skip
    yield (
        f"longest time under voltage, until 0 V was written: {longest_s:.1f} s "
        f"(limit {LONGEST_UNDER_VOLTAGE_S:g} s)"
    )


def _designs(made: dict[str, Piece]) -> Table:
    rows = tuple(
        (
            name,
            f"{one['sensitivity_peak']:.2f}",
            f"{1e3 * one['rise_s']:.0f} ms",
            f"{1e3 * one['settled_s']:.0f} ms",
            f"{100 * one['overshoot']:.0f} %",
        )
        for name, one in made.items()
    )
    columns = ("sheet, position, method", "Ms", "90 % after", "within 2 % after", "overshoot")
    return Table(f"A step of 1 mN within 2 V, linear model, {RATE_HZ:g} Hz, 3 ms", columns, rows)


def _moved(found: dict[str, Steps]) -> tuple[Table, Table]:
    rows = tuple(
        (
            name,
            f"{1e3 * one.predicted.settled_s:.0f} ms",
            f"{1e3 * one.found.settled_s:.0f} ms",
            f"{100 * one.predicted.overshoot:.0f} %",
            f"{100 * one.found.overshoot:.0f} %",
        )
        for name, one in found.items()
    )
    columns = ("method, seed", "within 2 %, linear", "found", "overshoot, linear", "found")
    each = Table("A step of 1 mN in the moving world, long sheet at 0 mm", columns, rows)
    return each, Table(
        "The same, all seeds",
        ("method", "runs", "median", "longest", "within twice the linear time", "90 % interval"),
        tuple(_summary(method, found) for method in METHODS),
    )


def _summary(method: str, found: dict[str, Steps]) -> Row:
    of_method = [one for name, one in found.items() if name.startswith(method)]
    if not of_method:
        return (method, "0", "", "", "", "")
    settled_ms = 1e3 * np.array([one.found.settled_s for one in of_method])
    good = sum(one.found.settled_s <= 2 * one.predicted.settled_s for one in of_method)
    low, high = wilson(good, len(of_method))
    return (
        method,
        str(len(of_method)),
        f"{np.median(settled_ms):.0f} ms",
        f"{settled_ms.max():.0f} ms",
        f"{good} of {len(of_method)}",
        f"{100 * low:.0f} to {100 * high:.0f} %",
    )


def _faults(ended: list[Ended]) -> Table:
    kinds: dict[str, list[Ended]] = defaultdict(list)
    for each in ended:
        kinds[each.name].append(each)
    rows = tuple(
        (
            name,
            str(len(all_of)),
            f"{sum(each.is_right for each in all_of)} "
            + ("at 0 V" if all_of[0].can_be_made_safe else "UNKNOWN"),
            f"{1e3 * max(each.zero_after_s for each in all_of):.0f} ms"
            if all_of[0].can_be_made_safe
            else "",
        )
        for name, all_of in kinds.items()
    )
    columns = ("fault", "runs", "ended as said", "slowest 0 V after the fault")
    return Table("Faults in the loop, on the rig's virtual clock", columns, rows)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=float("inf"))
    return parser.parse_args()


if __name__ == "__main__":
    print(report(Pieces("controller", _arguments().seconds)).text())

"""A controller at work: what the linear model says of it, and 0 V after each of 100 faults.

The designs are of the sheets of the examples at 200 Hz with 3 ms of delay. The faults come at
random moments of a controlled run on the simulated rig, at the wire: boards, load cell, camera and
time.
"""

from __future__ import annotations

from collections import defaultdict

from benchmarks._loop_faults import LONGEST_S, Ended, random_faults, run_with
from benchmarks._loop_step import Steps, steps
from benchmarks.report import Report, Table, busy
from model.dynamics.linear.linear_model import read_by
from model.dynamics.linear.loop_design import LoopDesign, designed
from tests.model.dynamics.sheets import SHORT, beam, model_of

FAULTS, SEED = 100, 7
WORLDS = (21, 22)  # seeds
CELL_HZ, CELL_DAMPING = 100.0, 0.02  # resonance of the moving world's load cell
RATE_HZ, DELAY_S, LIMIT_V = 200.0, 3e-3, 2.0
SHEETS = {"long, 0 mm": ({}, 0.0), "long, 15 mm": ({}, 0.015), "short, 5 mm": (SHORT, 0.005)}


def measure() -> Report:
    """Run it."""
    note = busy()
    made = {
        (name, method): _design(sheet, position_m, method)
        for name, (sheet, position_m) in SHEETS.items()
        for method in ("pi", "lqg")
    }
    moved = {(method, seed): _steps(method, seed) for method in ("pi", "lqg") for seed in WORLDS}
    ended = [run_with(fault) for fault in random_faults(FAULTS, SEED)]
    safe = sum(each.is_safe for each in ended)
    figures = {
        "designs": {f"{name}, {method}": _figures(one) for (name, method), one in made.items()},
        "faults": len(ended),
        "safe": safe,
        "zero_after_s": [each.zero_after_s for each in ended],
    }
    notes = (
        f"{safe} of {len(ended)} faults ended at 0 V, read back, with code 5 (seed {SEED})",
        f"boards refuse for up to 0.8 s, hang for up to {LONGEST_S:g} s: none takes 0 V then",
        *(f"NOT SAFE: {each.fault} ended with {each.code}" for each in ended if not each.is_safe),
        note,
    )
    return Report((_designs(made), _moved(moved), _faults(ended)), figures, notes)


def _steps(method: str, seed: int) -> Steps:
    plant = read_by(model_of(beam(), 0.0), CELL_HZ, CELL_DAMPING).output("force_N")
    made = designed(plant, method, rate_hz=RATE_HZ, delay_s=DELAY_S, limit_V=LIMIT_V)
    return steps(made, seed)


def _moved(found: dict[tuple[str, int], Steps]) -> Table:
    rows = tuple(
        (
            method,
            str(seed),
            f"{1e3 * one.predicted.settled_s:.0f} ms",
            f"{1e3 * one.found.settled_s:.0f} ms",
            f"{100 * one.predicted.overshoot:.0f} %",
            f"{100 * one.found.overshoot:.0f} %",
        )
        for (method, seed), one in found.items()
    )
    columns = ("method", "seed", "within 2 %, linear", "found", "overshoot, linear", "found")
    return Table("A step of 1 mN in the moving world, long sheet at 0 mm", columns, rows)


def _design(sheet: dict[str, object], position_m: float, method: str) -> LoopDesign:
    plant = model_of(beam(**sheet), position_m).output("force_N")
    return designed(plant, method, rate_hz=RATE_HZ, delay_s=DELAY_S, limit_V=LIMIT_V)


def _figures(one: LoopDesign) -> dict[str, float]:
    return {
        "sensitivity_peak": one.sensitivity_peak,
        "rise_s": one.step.rise_s,
        "settled_s": one.step.settled_s,
        "overshoot": one.step.overshoot,
    }


def _designs(made: dict[tuple[str, str], LoopDesign]) -> Table:
    rows = tuple(
        (
            name,
            method,
            f"{one.sensitivity_peak:.2f}",
            f"{1e3 * one.step.rise_s:.0f} ms",
            f"{1e3 * one.step.settled_s:.0f} ms",
            f"{100 * one.step.overshoot:.0f} %",
        )
        for (name, method), one in made.items()
    )
    columns = ("sheet", "method", "Ms", "90 % after", "within 2 % after", "overshoot")
    return Table("A step of 1 mN within 2 V, linear model, 200 Hz, 3 ms of delay", columns, rows)


def _faults(ended: list[Ended]) -> Table:
    kinds: dict[str, list[Ended]] = defaultdict(list)
    for each in ended:
        kinds[each.fault.what].append(each)
    rows = tuple(
        (
            what,
            str(len(all_of)),
            str(sum(each.is_safe for each in all_of)),
            f"{1e3 * max(each.zero_after_s for each in all_of):.0f} ms",
        )
        for what, all_of in kinds.items()
    )
    columns = ("fault", "runs", "ended at 0 V, read back", "slowest 0 V after the fault")
    return Table("Faults in the loop, on the rig's virtual clock", columns, rows)

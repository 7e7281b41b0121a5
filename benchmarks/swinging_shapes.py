"""Free shapes that swing, half a second after an edge: what `diagnose` names with nothing hidden.

Sessions of the world that moves (`benchmarks.worlds`, generator `moving`), long sheet, five
positions, one run of free shapes in the protocol's own pulses, with three losses. Each is diagnosed
with the shapes taken as those at rest (as before), with the data check that leaves them out, and
with the dynamics of the sheet. `python -m benchmarks.swinging_shapes --sessions 4 --seed 601`.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from unittest.mock import patch

import numpy as np
from scipy.stats import beta

from benchmarks._moving_dynamics import LOSSES, session, true_model
from model.discrepancy import DiagnoseOptions, diagnose
from model.discrepancy.data_checks import check
from model.measurements import Measurements

POSITIONS_M = (0.0, 0.0075, 0.015, 0.0225, 0.03)
WAYS = ("taken as at rest", "left out by the check", "with dynamics")


def answers(seed: int, loss: str) -> Iterator[tuple[str, str]]:
    """What is said in each way of one session."""
    data = session(seed, (), POSITIONS_M, loss=loss)
    model = true_model(seed, {}, data.sheets["long"], loss)
    with patch.object(check, "without_swinging", lambda m: (m, ())):
        yield WAYS[0], said(data, DiagnoseOptions())
    yield WAYS[1], said(data, DiagnoseOptions())
    yield WAYS[2], said(data, DiagnoseOptions(model=model))


def said(data: Measurements, options: DiagnoseOptions) -> str:
    found = diagnose(data, options)
    names = [one.name for one in found.effects]
    names += [] if found.unknown is None else [f"unknown ({found.unknown.location})"]
    return ", ".join(names) or found.verdict


def swing_mm(seed: int, loss: str) -> float:
    """How far the pictures of the free sheet's end under voltage are from rest, at most."""
    from model.discrepancy.at_rest.at_rest import at_rest

    data = session(seed, (), POSITIONS_M, loss=loss)
    rest = at_rest(data, true_model(seed, {}, data.sheets["long"], loss)).measurements
    off = [
        1e3 * float(np.hypot(a.curve.x_m[-1] - b.curve.x_m[-1], a.curve.y_m[-1] - b.curve.y_m[-1]))
        for one, other in zip(data.conditions, rest.conditions, strict=True)
        if one.position_m is None and one.voltage_V
        for a, b in zip(one.readings, other.readings, strict=True)
        if a.curve is not None and b.curve is not None
    ]
    return max(off)


def interval(count: int, of: int) -> str:
    """90 % interval of a share (Jeffreys)."""
    low, high = (float(beta.ppf(p, count + 0.5, of - count + 0.5)) for p in (0.05, 0.95))
    return f"{100 * low:.0f} - {100 * high:.0f} %"


def main() -> None:
    """Print a line a session and way, then the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sessions", type=int, default=4, help="of each loss")
    parser.add_argument("--seed", type=int, default=601, help="of the first session")
    parser.add_argument("--losses", nargs="+", choices=list(LOSSES), default=list(LOSSES))
    asked = parser.parse_args()
    table = []
    for loss in asked.losses:
        false = dict.fromkeys(WAYS, 0)
        swings = []
        for seed in range(asked.seed, asked.seed + asked.sessions):
            swings.append(swing_mm(seed, loss))
            for way, answer in answers(seed, loss):
                false[way] += answer not in ("nothing_missing", "cannot_tell")
                print(f"{loss}, {seed}, {swings[-1]:.1f} mm, {way}: {answer}", flush=True)
        table.append((loss, swings, false))
    print(f"\n| loss (damping ratio) | swing, mm | {' | '.join(WAYS)} |")
    print("|---|---|" + "---|" * len(WAYS))
    for loss, swings, false in table:
        n = asked.sessions
        cells = [f"{false[way]} of {n} ({interval(false[way], n)})" for way in WAYS]
        span = f"{min(swings):.1f} - {max(swings):.1f}"
        print(f"| {loss} ({LOSSES[loss][2]:g}) | {span} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()

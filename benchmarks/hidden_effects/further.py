"""The further measurements that a diagnosis asks for, made on the same sheet and rig."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.hidden_effects.cases import Case, Extras
from benchmarks.hidden_effects.recipe import BOTH, Recipe
from benchmarks.hidden_effects.sessions import Hidden, hidden_session
from benchmarks.hidden_effects.visible import Visible, Yardstick
from benchmarks.hidden_effects.visits import FREE_TRAIN, train_of, visits
from labrig.analysis.together import together
from model import Measurements

MOST_TIRED = 0.8  # of the EIBM that a worn sheet may lose
_DAY = 2**31  # from the seed of a session, below this, to that of its further one


def with_further(
    first: Hidden, bare: Measurements, extras: Sequence[str], exclude: Sequence[str] = ()
) -> tuple[Measurements, Visible]:
    """All sessions taken together, and what can be seen in them.

    `extras` are entries of the menu, each measured on a day of its own; `bare` is the first session
    with nothing hidden. Set-ups and noise are those of another day, the hidden effect is the same.
    They are recorded whole, whatever there is of the first one. A load cell that drifts is set to
    zero anew, and the sheet is wetted again; what is worn stays so.
    """
    cases = [
        replace(
            first.case, seed=first.case.seed + day * _DAY, further=extra, extras=Extras(),
            outlier=False, streams="all",
        )
        for day, extra in enumerate(extras, 1)
    ]  # fmt: skip
    before_s = np.cumsum([driven_s(one) for one in (first.case, *cases)]).tolist()
    worn = [on_day(c, past_s) for c, past_s in zip(cases, before_s, strict=False)]
    whole = _joined([first.measurements, *worn])
    plain = _joined([bare, *(hidden_session(c.bare).measurements for c in cases)])
    yardstick = Yardstick(plain, first.case.symmetric)
    return whole, yardstick.visible(whole, [whole], first.truth.names, exclude)


def driven_s(case: Case) -> float:
    """Return the time under voltage of a session, in s at 2 V."""
    train, total = train_of(case), 0.0
    for visit in visits(case):
        own = FREE_TRAIN if visit.position_m is None else train
        volts = 0.0 if visit.load_cell_alone else sum(map(abs, own.edges()))
        total += own.pulse_s * volts / 2.0
    return total


def on_day(case: Case, past_s: float) -> Measurements:
    """Return a session of a sheet that was under voltage for so long before."""

    def tired(recipe: Recipe) -> None:
        rate = recipe.world["water"]["tiring_per_min"] / 60.0 / MOST_TIRED
        for name in BOTH:
            recipe.weigh_moment(name, 1.0 + MOST_TIRED * math.expm1(-rate * past_s))

    return hidden_session(case, tired).measurements


def _joined(sessions: Sequence[Measurements]) -> Measurements:
    return together([(Path(f"session {i}"), one) for i, one in enumerate(sessions)])

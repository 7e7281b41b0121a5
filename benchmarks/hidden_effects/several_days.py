"""Sessions of several days in which something differs from day to day, and what is said of them.

`python -m benchmarks.hidden_effects.several_days --days 2 --seeds 1 2 3` prints what is named where
each of them differs, and where nothing does, and how many of the 90 % intervals hold the truth.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.hidden_effects.cases import NOTHING, Case
from benchmarks.hidden_effects.recipe import BOTH, LONG, Recipe
from benchmarks.hidden_effects.registry import form_of
from benchmarks.hidden_effects.sessions import hidden_session
from labrig.analysis.together import together
from model.discrepancy import Diagnosis, diagnose
from model.measurements import Measurements

Change = Callable[[Recipe, float], None]


@dataclass(frozen=True)
class Differing:
    """What differs from day to day; `size` is the standard deviation of a day's own value."""

    change: Change
    size: float
    from_first: bool = False  # whether differences from the first day are told


def _stiffness(recipe: Recipe, share: float) -> None:
    for name in BOTH:
        recipe.weigh_stiffness(name, 1.0 + share)


def _eibm(recipe: Recipe, share: float) -> None:
    for name in BOTH:
        recipe.weigh_moment(name, 1.0 + share)


DIFFERING = {
    "session_zero": Differing(form_of("force_offset").change, 0.3),
    "session_stiffness": Differing(_stiffness, 0.15, from_first=True),
    "session_eibm": Differing(_eibm, 0.15, from_first=True),
    "session_curvature": Differing(form_of("initial_curvature").change, 2.0, from_first=True),
    "session_position": Differing(form_of("position_error").change, 1.0),
    "session_scale": Differing(form_of("camera_scale").change, 0.03),
}


def values(effect: str, days: int, seed: int) -> list[float]:
    """Return a value for each day: 0 where nothing differs.

    Their mean is 0 where differences are told: a mean rest curvature that is not the stated one
    would be a further effect.
    """
    if effect not in DIFFERING:
        return [0.0] * days
    own = DIFFERING[effect].size * np.random.default_rng((seed, days)).standard_normal(days)
    if DIFFERING[effect].from_first:
        own = own - np.mean(own)
    return np.asarray(own).tolist()


def measured(effect: str, own: Sequence[float], seed: int) -> Measurements:
    """Return a session of each day, analysed together; the same arguments give the same data."""
    parts = []
    for day, value in enumerate(own, 1):
        changes = DIFFERING[effect].change if effect in DIFFERING else None

        def change(recipe: Recipe, value: float = value, changes: Change | None = changes) -> None:
            if changes is not None:
                changes(recipe, value)

        one = hidden_session(Case(seed=1000 * seed + day), change)
        parts.append((Path(f"day{day}.h5"), one.measurements))
    return together(parts)


def inside(effect: str, own: Sequence[float], found: Diagnosis) -> list[bool]:
    """Return for each value that is told whether its 90 % interval holds the truth."""
    named = next((one for one in found.effects if one.name == effect), None)
    if named is None or effect not in DIFFERING:
        return []
    truth = np.array(own)
    if DIFFERING[effect].from_first:
        truth = truth[1:] - truth[0]
    own_of_long = named.by_configuration.get(LONG, named.parameters)  # where it was changed
    ends = [p.interval() for p in own_of_long.values()]
    return [low <= value <= high for value, (low, high) in zip(truth, ends, strict=True)]


def main() -> None:
    """Print a line for each case, and how many are right."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--days", type=int, default=2)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--only", nargs="+", default=[NOTHING, *DIFFERING])
    asked = parser.parse_args()
    right, held, cases = 0, list[bool](), 0
    for seed in asked.seeds:
        for effect in asked.only:
            own = values(effect, asked.days, seed)
            data = measured(effect, own, seed)
            began = time.process_time()
            found = diagnose(data)
            seconds = time.process_time() - began
            names = [one.name for one in found.effects]
            right += names == [effect] or (effect == NOTHING and found.verdict == "nothing_missing")
            cases += 1
            held += inside(effect, own, found)
            told = ", ".join(f"{v:.3g}" for v in own)
            print(f"{seed} {effect} ({told}): {found.verdict} {names} {seconds:.1f} s CPU")
            print(f"   {found.sentence}")
    print(f"{right} of {cases} right; {sum(held)} of {len(held)} values in their interval")


if __name__ == "__main__":
    main()

"""The suite: which sessions are made, each told from the others by a key that never changes.

Families are mixed, so that any first part of the suite is a small suite. Case number i of a family
is the same however many cases are asked for: a longer run goes on where a shorter one ended.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np

from benchmarks.hidden_effects.cases import Case, Extras, Hiding
from benchmarks.hidden_effects.forms import Form
from benchmarks.hidden_effects.registry import CATALOGUE, OUTSIDE, forms_of

Sizing = Literal["form", "d", "gap"]
GOLDEN = 0.6180339887498949  # its multiples fill an interval evenly, whatever their number

# Forms in which the catalogue writes the effect, too; all others are other forms.
AS_IN_CATALOGUE = {
    "nonuniform_eibm": ("exp",), "initial_curvature": ("offset",), "eibm_asymmetry": ("ratio",),
    "nonuniform_stiffness": ("line",), "nonlinear_stiffness": (), "stiffness_drift": ("line",),
    "eibm_drift": ("line",), "viscoelastic_creep": (), "charging_lag": ("first_order",),
    "back_relaxation": ("single",), "first_pulse_transient": ("geometric",),
    "elongation_flexibility": ("uniform",), "gravity": ("weight",), "surface_tension": ("stays",),
    "clamp_compliance": ("linear",), "clamp_angle": ("tilt",), "roll_friction": ("sliding",),
    "roll_sticking": (), "roll_offset": ("above",),
    "force_offset": ("constant",), "force_drift": ("line",),
    "load_cell_misalignment": ("turned",), "load_cell_hysteresis": ("play",),
    "load_cell_compliance": ("linear",), "position_error": ("offset",), "camera_scale": ("both",),
    "camera_roll": ("turned",), "camera_perspective": ("along_x", "along_y"),
    "frame_delay": ("late",),
}  # fmt: skip
EXTRAS = Extras(
    free_shapes=True, remounts=3, random_order=True, reversed_approach=True, no_touch_zero=True
)


@dataclass(frozen=True)
class Task:
    """One session to be made and judged."""

    key: str  # FAMILY:NUMBER:SEED
    family: str
    case: Case  # the sizes of what is hidden are found as `sizing` says
    sizing: Sizing = "form"
    wanted: tuple[float, ...] = ()  # of each effect: d, or the gap in mN
    exclude: tuple[str, ...] = ()  # taken out of the catalogue
    calibrate: int = 0  # nulls


@dataclass(frozen=True)
class Family:
    """A kind of case."""

    name: str
    share: int  # of a full suite
    make: Callable[[int], Task]  # from the number, without key and seed


def tasks(count: int, seed: int = 0) -> list[Task]:
    """So many cases, in the order in which they are run, the families mixed by their shares."""
    whole = sum(f.share for f in FAMILIES)
    places = []
    for f in FAMILIES:
        number = max(1, round(f.share * count / whole))
        places += [((i + 0.5) / number, f, i) for i in range(number)]
    places.sort(key=lambda p: p[0])
    return [_numbered(f, i, seed) for _, f, i in places]


def _numbered(family: Family, i: int, seed: int) -> Task:
    key = f"{family.name}:{i}:{seed}"
    task = family.make(i)
    own = zlib.crc32(key.encode()) % 2**31
    return replace(task, key=key, family=family.name, case=replace(task.case, seed=own))


def as_in_catalogue(effect: str, form: str) -> bool:
    """Whether this is the form that the catalogue has."""
    return form in AS_IN_CATALOGUE.get(effect, ())


def forms(*, own: bool) -> list[Form]:
    """All forms of the catalogue's effects that are, or are not, the catalogue's."""
    every = [f for name in CATALOGUE for f in forms_of(name)]
    return [f for f in every if as_in_catalogue(f.effect, f.form) == own]


def spread(i: int, low: float, high: float, offset: float = 0.0) -> float:
    """The i-th of numbers that fill a range evenly in their logarithms."""
    return float(low * (high / low) ** ((i * GOLDEN + offset) % 1.0))


def _shuffled(found: list[Form]) -> list[Form]:
    """In a random order that is always the same: a small suite has some of everything."""
    return [found[k] for k in np.random.default_rng(len(found)).permutation(len(found))]


def _of(found: tuple[Form, ...]) -> Case:
    hidden = tuple(Hiding(f.effect, f.form) for f in found)
    return Case(hidden, symmetric=any(f.symmetric for f in found))


# ---------------------------------------------------------------------------------- the families

_KINDS: tuple[dict[str, object], ...] = (
    {}, {"outlier": True}, {"correlated": True}, {"extras": EXTRAS}, {"rest": "nodes"},
    {"rest": "constant"}, {"symmetric": True}, {"streams": "means"},
    {"outlier": True, "correlated": True},
)  # fmt: skip


def _nothing(i: int) -> Task:
    case = replace(Case(), scatter=(0.5, 1.0, 2.0)[i % 3], **_KINDS[i // 3 % len(_KINDS)])  # type: ignore[arg-type]
    return Task("", "", case)


def _single(low: float, high: float, *, own: bool) -> Callable[[int], Task]:
    pool = _shuffled(forms(own=own))

    def make(i: int) -> Task:
        turn, j = divmod(i, len(pool))
        return Task("", "", _of((pool[j],)), "d", (spread(turn + j, low, high),))

    return make


def _gap(i: int) -> Task:
    pool = _shuffled(forms(own=False))
    turn, j = divmod(i, len(pool))
    case = _of((pool[j],))
    if pool[j].felt_by == "curve":
        return Task("", "", case)
    return Task("", "", case, "gap", (spread(turn + j, 0.2, 0.6),))


def _means(i: int) -> Task:
    pool = _shuffled([*forms(own=False), *forms(own=True)])
    task = Task("", "", _of((pool[i % len(pool)],)), "d", (spread(i, 10.0, 100.0),))
    return replace(task, case=replace(task.case, streams="means"))


def _pairs() -> Callable[[int], Task]:
    """Pairs of different effects in a fixed random order, each in one of its forms."""
    every = list(combinations(CATALOGUE, 2))
    order = np.random.default_rng(20).permutation(len(every))

    def make(i: int) -> Task:
        names = every[int(order[i % len(every)])]
        found = tuple(forms_of(n)[(i + k) % len(forms_of(n))] for k, n in enumerate(names))
        # a tenth more: what both can explain counts for neither
        wanted = (spread(i, 10.0, 30.0), spread(i, 10.0, 30.0, 0.37))
        return Task("", "", _of(found), "d", wanted)

    return make


def _outside(i: int) -> Task:
    found = _shuffled([f for name in OUTSIDE for f in forms_of(name)])
    return Task("", "", _of((found[i % len(found)],)), "d", (spread(i, 36.0, 150.0),))


def _excluded(i: int) -> Task:
    turn, j = divmod(i, len(CATALOGUE))
    name = CATALOGUE[5 * j % len(CATALOGUE)]  # a step that meets all of them
    own = forms_of(name)
    form = own[turn % len(own)]
    return Task("", "", _of((form,)), "d", (spread(i, 36.0, 150.0),), exclude=(name,))


# Effects that have a neighbour within four sigmas at sizes at which others are clear.
CLOSE = (
    "stiffness_drift", "eibm_drift", "viscoelastic_creep", "first_pulse_transient",
    "back_relaxation", "charging_lag", "force_offset", "force_drift", "surface_tension",
    "camera_scale", "camera_perspective",
)  # fmt: skip


def _ambiguous(i: int) -> Task:
    """Three that look like others also when they are larger, then one that is hardly found.

    Only those count of which the diagnosis says that they cannot be told apart.
    """
    turn, j = divmod(i, 4)
    pool, low, high = _shuffled([*forms(own=True), *forms(own=False)]), 6.0, 9.0
    form = pool[turn % len(pool)]
    if j < 3:
        pool, low, high = [f for f in pool if f.effect in CLOSE], 8.0, 24.0
        form = pool[(3 * turn + j) % len(pool)]
    task = Task("", "", _of((form,)), "d", (spread(i, low, high),))
    return replace(task, case=replace(task.case, streams=("all", "means")[turn % 2]))


FAMILIES = (
    Family("nothing", 400, _nothing),
    Family("own_form", 196, _single(3.0, 120.0, own=True)),
    Family("other_form", 196, _single(3.0, 120.0, own=False)),
    Family("realistic", 112, _gap),
    Family("means_only", 84, _means),
    Family("pair", 84, _pairs()),
    Family("outside", 78, _outside),
    Family("excluded", 56, _excluded),
    Family("ambiguous", 40, _ambiguous),
)


FULL = sum(f.share for f in FAMILIES)


def nulls_task(seed: int = 0) -> Task:
    """The one case that is timed with a threshold from 500 simulated sessions."""
    task = _numbered(FAMILIES[0], 0, seed)
    return replace(task, key=f"nulls:0:{seed}", family="nulls", calibrate=500)

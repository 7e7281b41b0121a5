"""The cases of a world: which kinds are hidden, how large, and how the session is designed.

Case number i of a family is the same however many are asked for. Families are mixed by their
shares, so that any first part of a run is a small run.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from benchmarks.hidden_effects.sizes import found_size
from benchmarks.hidden_effects.suite import spread
from benchmarks.hidden_effects.visible import Visible, Yardstick
from benchmarks.worlds.contract import Design, World
from benchmarks.worlds.registry import world
from model.measurements import Measurements

SHARES = {"nothing": 0.3, "single": 0.4, "pair": 0.15, "outside": 0.15}
# asked for by its name alone: single effects whose parameters can be compared with what is told
CATALOGUE_FORM = "catalogue_form"
# likewise: an effect of the catalogue beside something that no catalogue has
MIXED = "mixed"
FAMILIES = (*SHARES, CATALOGUE_FORM, MIXED)
SINGLE_D, PAIR_D, OUTSIDE_D = (8.0, 120.0), (14.0, 60.0), (34.0, 150.0)
TOLERANCE = 0.15  # of a size found for a wanted d
PAPER = Design()
THOROUGH = Design(free_shapes=1, remounts=2, random_order=True)
EACH = 4  # of so many sessions one is measured thoroughly


@dataclass(frozen=True)
class Task:
    """One case, and who is asked."""

    key: str  # WORLD:FAMILY:NUMBER:SEED
    world: str
    family: str
    hidden: tuple[tuple[str, float], ...]  # kinds, and the wanted d of each
    thorough: bool
    seed: int  # of the session
    methods: tuple[str, ...] = ("diagnose",)
    left_out: bool = False  # ask again without one position

    @property
    def design(self) -> Design:
        """Return what is measured."""
        return THOROUGH if self.thorough else PAPER


def tasks(name: str, count: int, seed: int, families: Sequence[str] = tuple(SHARES)) -> list[Task]:
    """Return so many cases of a world, the families mixed by their shares."""
    shares = {f: SHARES.get(f, SHARES["single"]) for f in families}
    whole = sum(shares.values())
    places = []
    for family in families:
        number = max(1, round(shares[family] * count / whole))
        places += [((i + 0.5) / number, family, i) for i in range(number)]
    return [_task(name, family, i, seed) for _, family, i in sorted(places)]


def _task(name: str, family: str, i: int, seed: int) -> Task:
    key = f"{name}:{family}:{i}:{seed}"
    hidden = _hidden(world(name), family, i, seed)
    free = any("free_shapes" in world(name).kinds[kind].needs for kind, _ in hidden)
    return Task(
        key=key, world=name, family=family, hidden=hidden, thorough=free or i % EACH == EACH - 1,
        seed=zlib.crc32(key.encode()) % 2**31,
    )  # fmt: skip


def _hidden(one: World, family: str, i: int, seed: int) -> tuple[tuple[str, float], ...]:
    """Return the kinds of a case and the wanted d of each: all in turn, in a random order."""
    known = [name for name, kind in one.kinds.items() if (kind.known_as is None) == (
        family == "outside") and (kind.own_form or family != CATALOGUE_FORM)]  # fmt: skip
    order = np.random.default_rng((seed, len(known)))
    if family == "nothing":
        return ()
    if family in ("pair", MIXED):
        beyond = [name for name, kind in one.kinds.items() if kind.known_as is None]
        pairs = list(product(known, beyond)) if family == MIXED else [
            p for p in combinations(known, 2)
            if one.kinds[p[0]].known_as != one.kinds[p[1]].known_as
        ]  # fmt: skip
        chosen = pairs[order.permutation(len(pairs))[i % len(pairs)]]
        limits = (PAIR_D, OUTSIDE_D if family == MIXED else PAIR_D)
        return tuple((k, spread(i, *limits[j], 0.37 * j)) for j, k in enumerate(chosen))
    kind = known[order.permutation(len(known))[i % len(known)]]
    turn = i // len(known)
    limits = OUTSIDE_D if family == "outside" else SINGLE_D
    return ((kind, spread(turn + i % len(known), *limits)),)


@dataclass(frozen=True)
class Made:
    """A session with all that is known of it."""

    task: Task
    world: World
    sizes: Mapping[str, float]
    bare: Measurements
    session: Measurements
    visible: Visible


def made(task: Task, other: World | None = None) -> Made:
    """Return the session, its sizes found so that each kind alone has the wanted d.

    `other`: a world in place of that of the task's name.
    """
    one = other or world(task.world)
    bare = one.measure(task.design, {}, task.seed)
    yardstick = Yardstick(bare)
    if not task.hidden:
        return Made(task, one, {}, bare, bare, Visible((), (), {}, {}, {}))
    sizes = {kind: _size(one, task, kind, d, yardstick) for kind, d in task.hidden}
    session = as_stated(bare, one.measure(task.design, sizes, task.seed))
    parts = [session]
    if len(sizes) > 1:
        parts = [
            as_stated(bare, one.measure(task.design, {k: v}, task.seed)) for k, v in sizes.items()
        ]
    visible = yardstick.visible(session, parts, names(one, sizes))
    if task.family == MIXED:
        visible = _each_alone(visible, yardstick, parts, names(one, sizes))
    return Made(task, one, sizes, bare, session, visible)


def _each_alone(
    visible: Visible, yardstick: Yardstick, parts: Sequence[Measurements], both: Sequence[str]
) -> Visible:
    """Return what else looks like the effect, and what imitates the other one, each by itself."""
    effect, other = (
        yardstick.visible(part, [part], [name]) for part, name in zip(parts, both, strict=True)
    )
    return replace(visible, near=effect.near, left=other.left, left_tolerant=other.left_tolerant)


def as_stated(bare: Measurements, session: Measurements) -> Measurements:
    """Return a session with the sheets as they are stated where nothing is hidden.

    A generator may state the initial curvature that it has changed: then nothing would be hidden.
    """
    return replace(session, sheets=bare.sheets)


def names(one: World, hidden: Mapping[str, float]) -> list[str]:
    """Return the catalogue's names of kinds; their own where no catalogue has them."""
    return [one.kinds[kind].known_as or kind for kind in hidden]


def _size(one: World, task: Task, kind: str, wanted: float, yardstick: Yardstick) -> float:
    """Return the size at which a kind alone has the wanted d, or the largest that can be held."""
    told, held = one.kinds[kind], [0.0]

    def length(size: float) -> float:
        found = yardstick.length(one.measure(task.design, {kind: size}, task.seed))
        held.append(max(held[-1], size))
        return found

    try:
        return found_size(length, wanted, told.typical, told.largest, TOLERANCE)
    except ValueError:  # not even the largest that makes sense, or that the rig can hold
        if held[-1] == 0.0:
            raise
        return held[-1]

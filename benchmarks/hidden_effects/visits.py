"""Which runs a session has: the paper's with its extras, or a further measurement of the menu."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np

from benchmarks.hidden_effects.cases import Case
from benchmarks.hidden_effects.recipe import BOTH
from sim_hardware.world import Train, Visit

POSITIONS_M = tuple(round(0.005 * k, 3) for k in range(7))
FREE_TRAIN = Train(zero_readings=2, kept=2)
_ORDER_STREAM = 0xCE140


def train_of(case: Case) -> Train:
    """The pulses of each run that touches the load cell."""
    if case.further == "half_voltage":
        return Train(voltages=(1.0, -1.0))
    return Train(kept=30) if case.further == "long_runs" else Train()


def visits(case: Case) -> Iterator[Visit]:
    """The runs in their order, as a schedule has them."""
    if case.further:
        for name in BOTH:
            yield from FURTHER[case.further](case, name)
        return
    extras = case.extras
    random = np.random.default_rng((case.seed, _ORDER_STREAM))
    for name in BOTH:
        if extras.free_shapes:
            yield Visit(configuration=name, position_m=None)
        positions = list(POSITIONS_M)
        if extras.random_order:
            positions = [positions[k] for k in random.permutation(len(positions))]
        for turn, position in enumerate(positions, 1):
            if extras.no_touch_zero:
                yield Visit(configuration=name, position_m=None, turn=turn, load_cell_alone=True)
            yield Visit(configuration=name, position_m=position)
        if extras.reversed_approach:
            yield Visit(
                configuration=name,
                position_m=POSITIONS_M[len(POSITIONS_M) // 2],
                approach="down",
                turn=1,
            )
        for k in range(extras.remounts):
            again = round(k * (len(POSITIONS_M) - 1) / max(1, extras.remounts - 1))
            yield Visit(
                configuration=name, position_m=POSITIONS_M[again % len(POSITIONS_M)], mounting=1
            )


# -- entries of the menu, one sheet each: what their protocols do


def _everything(_case: Case, name: str) -> Iterator[Visit]:
    yield from (Visit(configuration=name, position_m=position) for position in POSITIONS_M)


def _free(_case: Case, name: str) -> Iterator[Visit]:
    yield Visit(configuration=name, position_m=None)


def _remount(_case: Case, name: str) -> Iterator[Visit]:
    yield from (
        Visit(configuration=name, position_m=POSITIONS_M[k]) for k in (0, len(POSITIONS_M) // 2, -1)
    )


def _reversed(_case: Case, name: str) -> Iterator[Visit]:
    yield from (
        Visit(configuration=name, position_m=position, approach="down")
        for position in POSITIONS_M[::-1]
    )


def _between(_case: Case, name: str) -> Iterator[Visit]:
    yield from (
        Visit(configuration=name, position_m=0.5 * (a + b)) for a, b in pairwise(POSITIONS_M)
    )


def _shuffled(case: Case, name: str) -> Iterator[Visit]:
    random = np.random.default_rng((case.seed, _ORDER_STREAM, BOTH.index(name)))
    yield from (
        Visit(configuration=name, position_m=POSITIONS_M[k])
        for k in random.permutation(len(POSITIONS_M))
    )


def _zeros(_case: Case, name: str) -> Iterator[Visit]:
    for turn, position in enumerate(POSITIONS_M):
        yield Visit(configuration=name, position_m=None, turn=turn, load_cell_alone=True)
        yield Visit(configuration=name, position_m=position)


def _turned(_case: Case, name: str) -> Iterator[Visit]:
    yield from (
        Visit(configuration=name, position_m=position, turned_over=True) for position in POSITIONS_M
    )


FURTHER: dict[str, Callable[[Case, str], Iterator[Visit]]] = {
    "free_shapes": _free, "remount": _remount, "long_runs": _remount,
    "reversed_approach": _reversed,
    "between": _between, "half_voltage": _everything, "random_order": _shuffled,
    "turned_over": _turned, "no_touch_zero": _zeros, "more_repeats": _everything,
}  # fmt: skip

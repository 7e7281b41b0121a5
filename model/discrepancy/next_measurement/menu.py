"""The candidate measurements: what each is, how long it takes, and the protocol that makes it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from model.discrepancy.next_measurement.added_conditions import (
    between,
    free_shapes,
    half_voltage,
    long_runs,
    positions_m,
    random_order,
    remounted,
    repeated,
    reversed_approach,
    turned_over,
    zeros_without_contact,
)
from model.identification.data.data_vector import ConditionData, DataVector

LONG_MINUTES = 1.5  # a position with three times as many pulses
RUN_MINUTES = 1.0  # a position: move, moisten, 32 readings
ZERO_MINUTES = 0.5  # the sheet out of the rolls, ten readings, and in again
TURN_MINUTES = 3.0  # the rig over, and everything in its place again


@dataclass(frozen=True, kw_only=True)
class CandidateMeasurement:
    """Something that can be measured besides."""

    name: str
    what: str
    minutes: Callable[[DataVector], float]
    add: Callable[[DataVector], tuple[ConditionData, ...]]
    protocol: dict[str, object]


def _minutes(runs: float) -> Callable[[DataVector], float]:
    return lambda _one: runs * RUN_MINUTES


def _runs(one: DataVector) -> float:
    return RUN_MINUTES * len(positions_m(one))


def _zero_runs(one: DataVector) -> float:
    return _runs(one) + ZERO_MINUTES * len(positions_m(one))


def _turned_runs(one: DataVector) -> float:
    return TURN_MINUTES + _runs(one)


MENU: tuple[CandidateMeasurement, ...] = (
    CandidateMeasurement(
        name="free_shapes",
        what="six free shapes of each configuration, the load cell moved away",
        minutes=_minutes(1.5),
        add=free_shapes,
        protocol={"extras": {"free_shapes": 6}},
    ),
    CandidateMeasurement(
        name="remount",
        what="three positions set anew",
        minutes=_minutes(3.0),
        add=remounted,
        protocol={"extras": {"remount": 3}},
    ),
    CandidateMeasurement(
        name="long_runs",
        what="three positions with three times as many pulses",
        minutes=_minutes(3.0 * LONG_MINUTES),
        add=long_runs,
        protocol={"pulse_train": {"readings_per_voltage": 30}},
    ),
    CandidateMeasurement(
        name="no_touch_zero",
        what="all positions again, each after the load cell's zero without contact",
        minutes=_zero_runs,
        add=zeros_without_contact,
        protocol={"extras": {"no_touch_zero": True}},
    ),
    CandidateMeasurement(
        name="reversed_approach",
        what="all positions again, approached from the other side",
        minutes=_runs,
        add=reversed_approach,
        protocol={"extras": {"reversed_approach": True}},
    ),
    CandidateMeasurement(
        name="between",
        what="positions half-way between those measured",
        minutes=_runs,
        add=between,
        protocol={"extras": {"between": True}},
    ),
    CandidateMeasurement(
        name="half_voltage",
        what="all positions at half the voltage",
        minutes=_runs,
        add=half_voltage,
        protocol={"extras": {"half_voltage": True}},
    ),
    CandidateMeasurement(
        name="random_order",
        what="all positions again in random order",
        minutes=_runs,
        add=random_order,
        protocol={"extras": {"random_order": True}},
    ),
    CandidateMeasurement(
        name="turned_over",
        what="all positions again with the rig turned over",
        minutes=_turned_runs,
        add=turned_over,
        protocol={"extras": {"tilt_deg": 180.0}},
    ),
    CandidateMeasurement(
        name="more_repeats",
        what="everything once more",
        minutes=_runs,
        add=repeated,
        protocol={"extras": {"repeat": 1}},
    ),
)

"""From a protocol and the places where it is run to the schedule of a whole session."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Literal

from protocols.errors import ScheduleError, require_count, require_number
from protocols.extras.contract import Extra, ExtraRun
from protocols.kinds.contract import ZERO_READINGS, ProtocolKind
from protocols.planning.builder import StepsAndReadings, require_size
from protocols.planning.schedule import PlannedRun, Purpose, Schedule


@dataclass(frozen=True)
class Place:
    """One configuration of the sheet, and the positions along the arc where it is measured.

    Without positions only extras are taken that need no load cell.
    """

    configuration: str
    positions_m: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.configuration:
            raise ScheduleError("places: a configuration has no name")
        for position_m in self.positions_m:
            require_number(f"places: a position of {self.configuration}", position_m)
        if len(set(self.positions_m)) < len(self.positions_m):
            raise ScheduleError(
                f"places: a position of {self.configuration} is there twice; state it once,"
                " and with [extras] remounts how many positions are set anew"
            )


@dataclass(frozen=True, kw_only=True)
class Extras:
    """Minutes at the rig that decide what can be known afterwards. As made here: none of them.

    `added` are those with runs of their own, a file of `protocols.extras` each; the other fields
    say how, and how often, the measurements themselves are made.
    """

    added: tuple[Extra, ...] = ()

    random_order_seed: int | None = None  # of the positions of a place; None: as they stand
    remounts: int = 0  # positions that are set anew and measured again, in each configuration
    no_touch_zero: bool = False  # the load cell's zero at each position, the sheet lifted out
    reversed_approach: bool = False  # the middle position again, from the other side
    dead_weights_N: tuple[float, ...] = ()  # hung on the load cell before everything else
    approach_from_m: float = 0.002  # how far beside a position its approach begins
    approach: Literal["up", "down"] = "up"  # from which side all positions are approached
    turned_over: bool = False  # the whole session with the rig turned over: weight changes sides

    def __post_init__(self) -> None:
        require_count("extras: remounts", self.remounts, least=0)
        for load_N in self.dead_weights_N:
            require_number("extras: a dead weight", load_N, above=0.0)
        require_number("extras: approach_from_m", self.approach_from_m, above=0.0)
        if self.approach not in ("up", "down"):
            raise ScheduleError(f"extras: approach = {self.approach!r}: should be up or down")


def make_schedule(
    protocol: ProtocolKind,
    places: Sequence[Place],
    *,
    extras: Extras | None = None,
    moisten: bool = True,
    frame_rate_hz: float = 25.0,
) -> Schedule:
    """All runs of a session in the order in which they are to be done.

    Dead weights first; then each configuration: the extras without the load cell, its positions
    (each after its no-touch zero), the extras in contact, the reversed approach and the re-mounted
    positions. Raises ScheduleError.
    """
    extras = extras or Extras()
    require_number("frame_rate_hz", frame_rate_hz, above=0.0)
    if not places:
        raise ScheduleError("places: there is none, so there is nothing to measure")
    names = [place.configuration for place in places]
    if len(set(names)) < len(names):
        raise ScheduleError("places: a configuration is there twice; put its positions together")
    planner = _Planner(protocol, extras, moisten)
    planner.weigh(places[0].configuration)
    for place in places:
        planner.visit(place)
    return Schedule(protocol.name, tuple(planner.runs), frame_rate_hz, planner.repeats())


def _parts_of(protocol: ProtocolKind) -> StepsAndReadings:
    found: object = protocol.steps_and_readings()  # of other people's protocols it may be anything
    if not isinstance(found, tuple) or len(found) != 3:
        raise ScheduleError(
            f"{protocol.name}: its steps_and_readings returned {type(found).__name__}, not steps, "
            "readings and duration; report it to its authors"
        )
    return found


class _Planner:
    def __init__(self, protocol: ProtocolKind, extras: Extras, moisten: bool) -> None:
        self.runs: list[PlannedRun] = []
        self._size = 0  # steps and readings of all of them
        self._protocol = protocol
        self._extras = extras
        self._moisten = moisten
        # One generator for all places, so that no two are shuffled alike. Only `random()` is
        # promised to give the same numbers in every version of Python, so positions are sorted
        # by it instead of shuffled.
        self._random = random.Random(extras.random_order_seed)  # noqa: S311 - no secret
        self._parts = _parts_of(protocol)
        self._load_cell_zero = _load_cell_zero(protocol)

    def weigh(self, configuration: str) -> None:
        """Return the dead weights, after a reading without any."""
        loads_N = self._extras.dead_weights_N
        for load_N in (0.0, *loads_N) if loads_N else ():
            self._add(configuration, None, Purpose.DEAD_WEIGHT, self._load_cell_zero, load_N=load_N)

    def visit(self, place: Place) -> None:
        """Everything in one configuration."""
        name, positions_m = place.configuration, self._ordered(place.positions_m)
        added = list(self._added(place))
        if not place.positions_m and not any(run.position_m is None for _, run in added):
            raise ScheduleError(
                f"places: {name} has no positions; only extras without the load cell, such as "
                "free shapes, can be taken without any"
            )
        for extra, run in added:
            if run.position_m is None:
                self._add(name, None, Purpose.FREE_SHAPE, run.parts, extra=extra, run=run)
        for position_m in positions_m:
            if self._extras.no_touch_zero:
                self._add(name, position_m, Purpose.NO_TOUCH_ZERO, self._load_cell_zero)
            self._measure(name, position_m)
        for extra, run in added:
            if run.position_m is not None:
                self._measure(name, run.position_m, extra=extra, run=run)
        if self._extras.reversed_approach and positions_m:
            middle_m = sorted(positions_m)[len(positions_m) // 2]
            other = "up" if self._extras.approach == "down" else "down"
            self._measure(name, middle_m, approach=other)
        for turn, position_m in enumerate(_spread(positions_m, self._extras.remounts)):
            self._measure(name, position_m, mounting=1 + turn // len(positions_m))

    def _added(self, place: Place) -> Iterator[tuple[str, ExtraRun]]:
        """Yield the runs that extras add to a place, with the extra's name."""
        for extra in self._extras.added:
            try:
                for run in extra.runs(self._protocol, place.positions_m):
                    yield extra.name, run
            except ScheduleError as error:
                raise ScheduleError(f"extras: {extra.name}: {error}") from None

    def repeats(self) -> tuple[PlannedRun, ...]:
        """Return a run to measure each measurement again, approached from the same side."""
        measured = [run for run in self.runs if run.measures]
        return tuple(
            self._again(run, index) for index, run in enumerate(measured, start=len(self.runs))
        )

    def _again(self, run: PlannedRun, index: int) -> PlannedRun:
        via_m = run.via_m
        if via_m is None and run.position_m is not None:
            side = -1.0 if run.approach == "up" else 1.0
            via_m = round(run.position_m + side * self._extras.approach_from_m, 9)
        return replace(run, index=index, repeats=run.index, via_m=via_m)

    def _ordered(self, positions_m: Iterable[float]) -> list[float]:
        if self._extras.random_order_seed is None:
            return list(positions_m)
        return sorted(positions_m, key=lambda _: self._random.random())

    def _measure(
        self,
        configuration: str,
        position_m: float,
        *,
        mounting: int = 0,
        approach: str = "",
        extra: str = "",
        run: ExtraRun | None = None,
    ) -> None:
        approach = approach or self._extras.approach
        side = -1.0 if approach == "up" else 1.0
        via_m = None
        if self._needs_approach(configuration, position_m, mounting, side):
            via_m = round(position_m + side * self._extras.approach_from_m, 9)
        self._add(
            configuration,
            position_m,
            Purpose.MEASUREMENT,
            self._parts if run is None else run.parts,
            mounting=mounting,
            approach=approach,
            via_m=via_m,
            extra=extra,
            run=run,
        )

    def _needs_approach(
        self, configuration: str, position_m: float, mounting: int, side: float
    ) -> bool:
        """Whether going straight to the position would come from the wrong side, or from none.

        A sheet that has just been mounted is put between the rolls where they are.
        """
        before = self.runs[-1] if self.runs else None
        mounted_now = (
            before is None
            or before.purpose is Purpose.DEAD_WEIGHT
            or before.configuration != configuration
            or mounting > 0
        )
        if mounted_now:
            return side > 0
        assert before is not None  # noqa: S101 - for the type checker
        if before.purpose is not Purpose.MEASUREMENT or before.position_m is None:
            return True
        stands_m = before.position_m if before.move is None else before.move.position_m
        return (stands_m - position_m) * side <= 0

    def _add(
        self,
        configuration: str,
        position_m: float | None,
        purpose: Purpose,
        parts: StepsAndReadings,
        *,
        mounting: int = 0,
        approach: str = "up",
        load_N: float | None = None,
        via_m: float | None = None,
        extra: str = "",
        run: ExtraRun | None = None,
    ) -> None:
        steps, readings, duration_s = parts
        self._size += len(steps) + len(readings)
        require_size(self._size)
        driven = any(step.voltage_V for step in steps)
        self.runs.append(
            PlannedRun(
                index=len(self.runs),
                configuration=configuration,
                position_m=position_m,
                purpose=purpose,
                mounting=mounting,
                approach=approach,
                moisten=self._moisten and driven,
                load_N=load_N,
                steps=steps,
                readings=readings,
                duration_s=duration_s,
                via_m=via_m,
                tilt_rad=pi if self._extras.turned_over else 0.0,
                extra=extra,
                keep_all_frames=run is not None and run.keep_all_frames,
                move=None if run is None else run.move,
            )
        )


def _spread(positions_m: Sequence[float], count: int) -> list[float]:
    """`count` positions, spread evenly from the first to the last; again from the start if more."""
    rising = sorted(positions_m)
    if not rising:
        return []
    if count >= len(rising):
        return [rising[i % len(rising)] for i in range(count)]
    if count == 1:
        return [rising[len(rising) // 2]]
    return [rising[round(i * (len(rising) - 1) / (count - 1))] for i in range(count)]


def _load_cell_zero(protocol: ProtocolKind) -> StepsAndReadings:
    """Return as many readings of the load cell alone as the protocol begins with at 0 V."""
    pulses = protocol.pulses()
    return pulses.zero_of_load_cell(pulses.zero_readings or ZERO_READINGS)

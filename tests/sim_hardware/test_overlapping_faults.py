"""Faults of a simulated rig that overlap: each acts from its own beginning to its own end."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from sim_hardware.clock import VirtualClock
from sim_hardware.families import FOLDER as FAMILIES
from sim_hardware.families import BoardOptions
from sim_hardware.faults import FaultyRig
from sim_hardware.world import FaultSettings, World, load_world
from tests.cases import few

LONG = (1.0, 4.0)
LATER = (2.0, 6.0)


def rig_with(*faults: tuple[str, tuple[float, float], float]) -> FaultyRig:
    """A rig of NI boards whose faults, each with its span and amount, are on their way."""
    clock = VirtualClock()
    settings = load_world(None).model_copy(
        update={
            "faults": tuple(
                FaultSettings(what=what, from_s=from_s, until_s=until_s, amount_s=amount_s)
                for what, (from_s, until_s), amount_s in faults
            )
        }
    )
    world = World(settings, clock)
    boards = FAMILIES.get("ni").make(world, clock, BoardOptions())
    rig = FaultyRig(clock=clock, world=world, boards=boards)
    rig.begin()
    return rig


def seen(rig: FaultyRig, look: Callable[[FaultyRig], object], *at_s: float) -> list[object]:
    found = []
    for when in at_s:
        rig.clock.sleep_until(when)
        found.append(look(rig))
    return found


KINDS: list[tuple[str, Callable[[FaultyRig], object]]] = [
    ("daq_refused", lambda rig: rig.boards.server.faults.unavailable),
    ("daq_hung", lambda rig: rig.boards.server.faults.hangs("StopTask")),
    ("force_nan", lambda rig: bool(rig.boards.server.faults.nan)),
    ("cell_overloaded", lambda rig: rig.world._cell._fault == "overloaded"),
    ("current_saturated", lambda rig: "current" in rig.world._broken),
    ("serial_silent", lambda rig: 0 in rig.serial.silent),
    ("serial_unplugged", lambda rig: rig.serial.unplugged),
]


@pytest.mark.parametrize(("what", "look"), few(KINDS, first=3))
def test_the_end_of_one_does_not_end_another_of_its_kind(
    what: str, look: Callable[[FaultyRig], object]
) -> None:
    rig = rig_with((what, LONG, 0.2), (what, LATER, 0.2))
    assert seen(rig, look, 0.5, 1.5, 3.0, 5.0, 7.0) == [False, True, True, True, False]


def test_of_two_delays_the_longer_lasting_one_acts_again_when_the_other_ends() -> None:
    rig = rig_with(("daq_slow", (1.0, 6.0), 0.2), ("daq_slow", (2.0, 4.0), 0.5))
    delays = seen(rig, lambda rig: rig.boards.server.faults.delay_s, 1.5, 3.0, 5.0, 7.0)
    assert delays == [0.2, 0.5, 0.2, 0.0]


def test_faults_of_two_kinds_in_one_place_both_act() -> None:
    rig = rig_with(("force_nan", LONG, 0.2), ("drive_nan", LATER, 0.2))
    inputs = [
        len(each) for each in seen(rig, lambda rig: {*rig.boards.server.faults.nan}, 1.5, 3.0)
    ]
    assert inputs[1] == 2 * inputs[0] > 0
    assert len(rig.boards.server.faults.nan) == 2 * inputs[0]
    rig.clock.sleep_until(5.0)
    assert len(rig.boards.server.faults.nan) == inputs[0]


def test_calls_that_hang_for_two_reasons_hang_until_the_second_ends() -> None:
    rig = rig_with(("daq_read_hung", LONG, 0.2), ("daq_hung", LATER, 0.2))
    look = lambda rig: (  # noqa: E731
        rig.boards.server.faults.hangs("ReadAnalogF64"),
        rig.boards.server.faults.hangs("StopTask"),
    )
    assert seen(rig, look, 1.5, 3.0, 5.0, 7.0) == [
        (True, False),
        (True, True),
        (True, True),
        (False, False),
    ]


def test_a_broken_wire_is_one_again_when_an_overload_within_it_ends() -> None:
    rig = rig_with(("cell_unplugged", (1.0, 6.0), 0.2), ("cell_overloaded", (2.0, 4.0), 0.2))
    look = lambda rig: rig.world._cell._fault.value  # noqa: E731
    assert seen(rig, look, 1.5, 3.0, 5.0, 7.0) == ["open", "overloaded", "open", "none"]


def test_a_jump_of_the_clock_happens_once() -> None:
    """And not again when the span of another ends."""
    rig = rig_with(("clock_jump", (1.0, 20.0), 10.0), ("clock_jump", (5.0, 21.0), 5.0))
    assert seen(rig, lambda rig: rig.clock.now(), 2.0, 20.5) == [16.0, 20.5]

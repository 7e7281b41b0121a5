"""The stage's driver against the simulated stage, in memory and on a pseudo-terminal."""

import math
import sys
from dataclasses import dataclass, field
from types import SimpleNamespace

import pytest

from drivers.interfaces import (
    DeviceError,
    DeviceTimeoutError,
    LimitError,
    Positioner,
    Prompt,
    RealClock,
)
from drivers.positioners.manual import ManualStage
from drivers.positioners.zaber import ZaberStage
from sim_hardware import serial_devices as simulated
from sim_hardware.clock import VirtualClock

RADIUS_M = 0.04
STEP_M = math.radians(0.000234375) * RADIUS_M


@dataclass
class Arc:
    """The world as the stage sees it: an arc, and where the load cell was put."""

    settings: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(arc=SimpleNamespace(radius_mm=RADIUS_M * 1e3))
    )
    placed_m: list[float | None] = field(default_factory=list)

    def place(self, position_m: float | None, approach: str = "up") -> None:
        self.placed_m.append(position_m)


class Person:
    """Answers as told."""

    def __init__(self, answer: bool) -> None:
        self.answer = answer
        self.asked: list[Prompt] = []

    def ask(self, prompt: Prompt) -> bool:
        self.asked.append(prompt)
        return self.answer


class Bench:
    """A simulated stage and its driver."""

    def __init__(self, faults=None, homed: bool = True, **driver) -> None:
        self.clock = VirtualClock()
        self.arc = Arc()
        self.device = simulated.SimulatedZaberStage(self.arc, self.clock, homed=homed)
        self.stage = ZaberStage(
            "COM2",
            self.clock,
            RADIUS_M,
            serial_factory=lambda port, **settings: simulated.InMemorySerial(
                self.device, self.clock, port=port, faults=faults, **settings
            ),
            **driver,
        )


def test_a_position_is_an_angle_times_the_radius():
    bench = Bench()
    assert isinstance(bench.stage, Positioner)
    bench.stage.open()
    for position_m in (0.015, 0.030, 0.0, 0.005):
        assert bench.stage.move_to(position_m) is True
        assert bench.stage.position() == pytest.approx(position_m, abs=STEP_M)
        assert bench.device.axis.position_m == pytest.approx(position_m, abs=STEP_M)
        assert bench.arc.placed_m[-1] == pytest.approx(position_m, abs=STEP_M)
    bench.stage.close()
    bench.stage.close()


def test_origin_and_direction_place_the_arc_on_the_stage():
    bench = Bench(origin_rad=1.0, direction=-1)
    bench.stage.open()
    bench.stage.move_to(0.010)
    assert bench.device.axis.position_m == pytest.approx(
        (1.0 - 0.010 / RADIUS_M) * RADIUS_M, abs=STEP_M
    )
    assert bench.stage.position() == pytest.approx(0.010, abs=STEP_M)


def test_moving_takes_the_time_that_its_speed_gives():
    bench = Bench()
    bench.stage.open()
    began = bench.clock.now()
    bench.stage.move_to(0.030)
    degrees = math.degrees(0.030 / RADIUS_M)
    speed_deg_per_s = 153_600 / 1.6384 * 0.000234375
    assert bench.clock.now() - began == pytest.approx(degrees / speed_deg_per_s, abs=0.3)


@pytest.mark.parametrize("position_m", [-0.001, 0.26, math.nan, math.inf])
def test_a_position_out_of_reach_is_refused_before_anything_moves(position_m):
    bench = Bench()
    bench.stage.open()
    with pytest.raises(LimitError, match=r"outside its range of 0\.00 to 251\.33 mm"):
        bench.stage.move_to(position_m)
    assert bench.arc.placed_m == []


def test_a_stage_that_must_be_homed_says_so_and_does_not_move_by_itself():
    bench = Bench(homed=False)
    with pytest.raises(DeviceError, match="no reference position"):
        bench.stage.open()
    assert bench.arc.placed_m == []


def test_a_stage_is_homed_on_opening_where_that_was_allowed():
    bench = Bench(homed=False, home_on_open=True)
    bench.stage.open()
    assert bench.stage.position() == pytest.approx(0.0, abs=STEP_M)
    bench.stage.move_to(0.01)
    assert bench.device.axis.position_m == pytest.approx(0.01, abs=STEP_M)
    assert bench.stage.warnings == ["no reference position: it must be homed (WR)"]


def test_the_operator_is_asked_before_the_stage_is_homed():
    person = Person(answer=True)
    bench = Bench(homed=False, operator=person)
    bench.stage.open()
    assert [prompt.kind for prompt in person.asked] == ["confirm"]
    assert bench.device.axis.position_m == pytest.approx(0.0, abs=STEP_M)
    again = Bench(homed=True, operator=Person(answer=False))
    again.stage.open()  # one that knows where it is does not ask


def test_a_stage_stays_where_it_is_when_the_operator_declines():
    bench = Bench(homed=False, operator=Person(answer=False))
    before = bench.device.axis.position_m
    with pytest.raises(DeviceError, match="no reference position"):
        bench.stage.open()
    assert bench.device.axis.position_m == before


def test_a_stall_is_reported_and_can_be_recovered_from():
    bench = Bench()
    bench.device.axis.obstacle_rad = 0.02 / RADIUS_M
    bench.stage.open()
    with pytest.raises(DeviceError, match=r"moving to 30 mm failed: stalled and stopped \(FS\)"):
        bench.stage.move_to(0.030)
    bench.device.axis.obstacle_rad = None
    bench.stage.home()
    assert bench.stage.move_to(0.010)
    assert bench.device.axis.position_m == pytest.approx(0.010, abs=STEP_M)


def test_a_stage_slower_than_it_says_is_stopped_and_given_up():
    bench = Bench()
    bench.stage.open()
    bench.device.settings.write("maxspeed", 1000)
    with pytest.raises(DeviceTimeoutError, match="it was stopped"):
        bench.stage.move_to(0.030)
    bench.clock.sleep_until(bench.clock.now() + 1.0)
    here = bench.device.axis.position_m
    bench.clock.sleep_until(bench.clock.now() + 5.0)
    assert bench.device.axis.position_m == here


def test_a_silent_stage_is_given_up_in_bounded_time():
    faults = simulated.SerialFaults(silent=range(1000))
    bench = Bench(faults)
    with pytest.raises(DeviceTimeoutError, match=r"did not answer 'get limit\.min'"):
        bench.stage.open()
    assert bench.clock.now() < 3.0


def test_garbage_is_not_taken_for_a_position():
    faults = simulated.SerialFaults()
    bench = Bench(faults)
    bench.stage.open()
    faults.garbage = range(4, 100)
    with pytest.raises(DeviceError):
        bench.stage.position()


def test_another_device_on_the_chain_is_not_taken_for_ours():
    bench = Bench(device=2)
    with pytest.raises(DeviceTimeoutError):
        bench.stage.open()


def test_checksums_and_alerts_do_not_disturb():
    bench = Bench()
    bench.device.settings.write("comm.checksum", 1)
    bench.device.settings.write("comm.alert", 1)
    bench.stage.open()
    bench.stage.move_to(0.02)
    bench.stage.move_to(0.01)
    assert bench.stage.position() == pytest.approx(0.01, abs=STEP_M)


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals are POSIX")
def test_the_stage_moves_over_a_real_port():
    clock, arc = RealClock(), Arc()
    port = simulated.PtyPort(simulated.SimulatedZaberStage(arc, clock, homed=True))
    try:
        stage = ZaberStage(port.path, clock, RADIUS_M)
        stage.open()
        assert stage.move_to(0.002)
        assert stage.position() == pytest.approx(0.002, abs=STEP_M)
        stage.close()
    finally:
        port.stop()


@pytest.mark.parametrize("answer", [True, False])
def test_a_stage_moved_by_hand_asks_and_passes_the_answer_on(answer):
    person = Person(answer)
    stage = ManualStage(person)
    assert isinstance(stage, Positioner)
    stage.open()
    assert stage.move_to(0.005) is answer
    assert stage.position() is None
    stage.close()
    (prompt,) = person.asked
    assert (prompt.kind, prompt.position_m) == ("move", 0.005)
    assert prompt.text == "Set the load cell to 5 mm on the arc."

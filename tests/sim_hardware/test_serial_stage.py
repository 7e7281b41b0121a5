"""The simulated rotary stage, message by message."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from sim_hardware.serial_devices import SimulatedZaberStage
from sim_hardware.serial_devices.motion import Motion

STEP_M = math.radians(0.000234375) * 0.04
SPEED = 153_600 / 1.6384
ACCELERATION = 205 * 10_000 / 1.6384


class Clock:
    def __init__(self) -> None:
        self.now_s = 7.0

    def now(self) -> float:
        return self.now_s


class World:
    settings = SimpleNamespace(arc=SimpleNamespace(radius_mm=40.0))

    def __init__(self) -> None:
        self.places: list[tuple[float | None, str]] = []

    def place(self, position_m: float | None, approach: str = "up") -> None:
        self.places.append((position_m, approach))


class Bench:
    """A stage with its clock and world, spoken to line by line."""

    def __init__(self, **settings) -> None:
        self.clock, self.world = Clock(), World()
        self.stage = SimulatedZaberStage(self.world, self.clock, **settings)

    def ask(self, line: str) -> str:
        return self.stage.respond(line.encode() + b"\n").decode()

    def wait(self, seconds: float) -> None:
        self.clock.now_s += seconds


@pytest.fixture
def bench() -> Bench:
    return Bench(homed=True)


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        ("/", "@01 0 OK IDLE -- 0"),
        ("/1 1", "@01 1 OK IDLE -- 0"),
        ("/01 tools echo hi there", "@01 0 OK IDLE -- hi there"),
        ("/01 tools echo:8F", "@01 0 OK IDLE -- 0"),
        ("/1 1 get pos", "@01 1 OK IDLE -- 0"),
        ("/1 1 42 get maxspeed", "@01 1 42 OK IDLE -- 153600"),
        ("/1 get version", "@01 0 OK IDLE -- 6.28"),
        ("/1 set maxspeed 0x100", "@01 0 OK IDLE -- 0"),
        ("/1 set maxspeed 0", "@01 0 RJ IDLE -- BADDATA"),
        ("/1 set maxspeed fast", "@01 0 RJ IDLE -- BADDATA"),
        ("/1 set maxspeed", "@01 0 RJ IDLE -- BADCOMMAND"),
        ("/1 set version 7", "@01 0 RJ IDLE -- BADCOMMAND"),
        ("/1 1 get version", "@01 1 RJ IDLE -- DEVICEONLY"),
        ("/1 get cloop.mode", "@01 0 RJ IDLE -- BADCOMMAND"),
        ("/1 2 get pos", "@01 2 RJ IDLE -- BADAXIS"),
        ("/1 dance", "@01 0 RJ IDLE -- BADCOMMAND"),
        ("/1 move abs 1536001", "@01 0 RJ IDLE -- BADDATA"),
        ("/1 move rel -1", "@01 0 RJ IDLE -- BADDATA"),
        ("/1 move sideways 3", "@01 0 RJ IDLE -- BADCOMMAND"),
        ("/1 move abs", "@01 0 RJ IDLE -- BADDATA"),
        ("/1 warnings", "@01 0 OK IDLE -- 00"),
        ("/1 move abs 1000", "@01 0 OK BUSY -- 0"),
    ],
)
def test_messages_are_answered_as_the_manual_has_it(bench: Bench, line: str, reply: str) -> None:
    assert bench.ask(line) == reply + "\r\n"


@pytest.mark.parametrize("line", ["/2 get pos", "get pos", "/01 tools echo:8E", "", "/1 1 -- home"])
def test_some_messages_are_not_answered(bench: Bench, line: str) -> None:
    assert bench.ask(line) == ""


def test_lines_may_come_in_pieces_and_end_in_any_newline(bench: Bench) -> None:
    assert bench.stage.respond(b"/1 get ") == b""
    assert bench.stage.respond(b"pos\r") == b"@01 0 OK IDLE -- 0\r\n"
    assert bench.stage.respond(b"\n/\r\n/\n") == b"@01 0 OK IDLE -- 0\r\n" * 2


def test_a_move_takes_the_time_of_its_speed_and_acceleration(bench: Bench) -> None:
    steps = 128_000
    duration = steps / SPEED + SPEED / ACCELERATION
    bench.ask(f"/1 1 move abs {steps}")
    bench.wait(duration / 2)
    assert bench.ask("/1 1 get pos") == f"@01 1 OK BUSY -- {steps // 2}\r\n"
    bench.wait(duration / 2 - 1e-3)
    assert "BUSY" in bench.ask("/1 1")
    assert bench.world.places == []
    bench.wait(2e-3)
    assert bench.ask("/1 1 get pos") == f"@01 1 OK IDLE -- {steps}\r\n"
    assert bench.world.places == [(pytest.approx(steps * STEP_M, abs=1e-12), "up")]


def test_the_world_is_told_from_which_side_a_place_was_reached(bench: Bench) -> None:
    for target in (50_000, 10_000):
        bench.ask(f"/1 1 move abs {target}")
        bench.wait(5)
        bench.stage.poll()
    assert [approach for _, approach in bench.world.places] == ["up", "down"]


def test_after_power_up_it_must_be_homed() -> None:
    bench = Bench(power_up_angle_rad=0.25, origin_m=0.001)
    assert bench.ask("/1 1") == "@01 1 OK IDLE WR 0\r\n"
    assert bench.ask("/1 1 move abs 1000") == "@01 1 RJ IDLE WR BADDATA\r\n"
    assert bench.stage.axis.position_m == pytest.approx(0.001 + 0.25 * 0.04)
    assert bench.ask("/1 1 home") == "@01 1 OK BUSY WR 0\r\n"
    bench.wait(10)
    assert bench.ask("/1 1 get pos") == "@01 1 OK IDLE -- 0\r\n"
    assert bench.world.places == [(pytest.approx(0.001), "down")]
    assert bench.ask("/1 1 move abs 1000") == "@01 1 OK BUSY -- 0\r\n"


def test_stop_brakes_and_leaves_the_warning_that_a_move_was_interrupted(bench: Bench) -> None:
    bench.ask("/1 1 move max")
    bench.wait(1)
    assert bench.ask("/1 1 stop") == "@01 1 OK BUSY NI 0\r\n"
    bench.wait(SPEED / ACCELERATION + 1e-6)
    reply = bench.ask("/1 1 get pos")
    assert reply.startswith("@01 1 OK IDLE NI ")
    # One second, less half the time that speeding up takes, and half of what slowing down takes.
    assert int(reply.split()[-1]) == pytest.approx(SPEED, abs=2)
    assert bench.ask("/1 1 warnings") == "@01 1 OK IDLE NI 01 NI\r\n"
    bench.ask("/1 1 move min")
    bench.wait(5)
    assert bench.ask("/1 1") == "@01 1 OK IDLE -- 0\r\n"


def test_estop_halts_at_once(bench: Bench) -> None:
    bench.ask("/1 1 move abs 500000")
    bench.wait(1)
    assert bench.ask("/1 1 estop") == "@01 1 OK BUSY NI 0\r\n"
    assert "IDLE" in bench.ask("/1 1")


def test_a_new_target_on_the_way_is_reached_without_a_jump(bench: Bench) -> None:
    bench.ask("/1 1 move abs 200000")
    bench.wait(1)
    before = bench.stage.axis.position_m
    assert " NI " in bench.ask("/1 1 move abs 20000")
    track = []
    for _ in range(300):
        bench.wait(0.01)
        track.append(bench.stage.axis.position_m)
    assert np.abs(np.diff([before, *track])).max() <= SPEED * STEP_M * 0.01 * (1 + 1e-9)
    assert max(track) > before
    assert track[-1] == pytest.approx(20_000 * STEP_M)


def test_moving_with_a_velocity_ends_at_the_limit(bench: Bench) -> None:
    bench.ask("/1 1 set limit.max 30000")
    bench.ask("/1 1 move vel 16384")
    bench.wait(2)
    assert int(bench.ask("/1 1 get pos").split()[-1]) == pytest.approx(20_000, rel=0.01)
    bench.wait(2)
    assert bench.ask("/1 1 get pos") == "@01 1 OK IDLE -- 30000\r\n"


def test_an_obstacle_stalls_it_until_the_warning_is_cleared(bench: Bench) -> None:
    bench.stage.axis.obstacle_rad = 0.2
    bench.ask("/1 1 move abs 100000")
    bench.wait(5)
    step = round(0.2 / math.radians(0.000234375))
    reply = bench.ask("/1 1 get pos")
    assert reply.startswith("@01 1 OK IDLE FS")
    assert int(reply.split()[-1]) == pytest.approx(step, abs=2)
    bench.ask("/1 1 move abs 100000")
    bench.wait(5)
    assert int(bench.ask("/1 1 get pos").split()[-1]) == pytest.approx(step, abs=2)
    assert bench.ask("/1 1 warnings clear") == "@01 1 OK IDLE -- 01 FS\r\n"
    bench.ask("/1 1 move abs 1000")
    bench.wait(5)
    assert bench.ask("/1 1 get pos") == "@01 1 OK IDLE -- 1000\r\n"


def test_alerts_and_check_sums_when_they_are_switched_on(bench: Bench) -> None:
    bench.ask("/1 set comm.alert 1")
    bench.ask("/1 1 move abs 100")
    bench.wait(1)
    assert bench.stage.poll() == b"!01 1 IDLE --\r\n"
    assert bench.stage.poll() == b""
    bench.ask("/1 1 move abs 200")
    bench.wait(1)
    assert bench.ask("/1 1") == "!01 1 IDLE --\r\n@01 1 OK IDLE -- 0\r\n"
    reply = bench.ask("/1 set comm.checksum 1")
    body, check = reply[1:].rstrip().split(":")
    assert (sum(body.encode()) + int(check, 16)) % 256 == 0


def test_its_address_can_be_changed(bench: Bench) -> None:
    assert bench.ask("/1 renumber 4") == "@04 0 OK IDLE -- 0\r\n"
    assert bench.ask("/1") == ""
    assert bench.ask("/4 renumber 100") == "@04 0 RJ IDLE -- BADDATA\r\n"


def test_a_reset_forgets_the_reference_but_moves_nothing(bench: Bench) -> None:
    bench.ask("/1 1 move abs 40000")
    bench.wait(5)
    bench.ask("/1 system reset")
    assert bench.ask("/1 1 get pos") == "@01 1 OK IDLE WR 0\r\n"
    assert bench.stage.axis.position_m == pytest.approx(40_000 * STEP_M)
    bench.ask("/1 1 home")
    bench.wait(5)
    bench.stage.poll()
    assert bench.world.places[-1] == (pytest.approx(0, abs=1e-12), "down")


@pytest.mark.parametrize("target", [30.0, 2.0, -5.0, 0.0])
@pytest.mark.parametrize("speed", [0.0, 3.0, 9.0, -2.0])
def test_motion_keeps_to_speed_and_acceleration(target: float, speed: float) -> None:
    motion = Motion(2.0, 0.0, speed).go(target, 5.0, 4.0)
    at = np.linspace(1.9, motion.end_s + 0.1, 4001)
    position = np.array([motion.position_at(t) for t in at])
    inside = (at > 2.0) & (at < motion.end_s)
    found = np.array([motion.speed_at(t) for t in at])
    step = at[1] - at[0]
    assert position[0] == 0
    assert position[-1] == pytest.approx(target)
    assert np.abs(found[inside]).max(initial=0) <= max(5.0, abs(speed)) + 1e-9
    assert np.abs(np.diff(found[inside])).max(initial=0) <= 4.0 * step + 1e-9
    travelled = np.concatenate(([0], np.cumsum((found[1:] + found[:-1]) / 2 * step)))
    assert np.abs(travelled - position).max() < 10 * step

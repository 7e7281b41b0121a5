"""The guard as a process of its own: programs that die, hang or go mad, over a real connection."""

from __future__ import annotations

import dataclasses
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from drivers import Guard, GuardSettings
from drivers.boards.ni.analog_output import NiVoltageOutput
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.rescue import OutputPlace, shut_down
from drivers.interfaces import DeviceError, RealClock
from drivers.safe_shutdown import Safety
from sim_hardware.ni import LoopbackWires, NiDeviceServer
from tests.cases import few
from tests.processes import ended

pytestmark = pytest.mark.slow
posix = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
VICTIM = Path(__file__).with_name("guard_victim.py")
AFTER_A_KILL_S, AFTER_A_HANG_S = 0.3, 1.0
CLOCK = RealClock()


class RecordingBench(LoopbackWires):
    """Remembers every change of the output, with its time on the computer's clock."""

    def __init__(self) -> None:
        super().__init__({"ao0": "ai2"})
        self.changes: list[tuple[float, float]] = []

    def write(self, device: str, channel: str, volts: float, when: float) -> None:
        self.changes.append((CLOCK.now(), volts))
        super().write(device, channel, volts, when)

    @property
    def volts(self) -> float:
        return self.changes[-1][1] if self.changes else 0.0

    def zeroed_after(self, when: float) -> float:
        """Seconds from `when` to the first time after it that the output became 0 V."""
        return next(time for time, volts in self.changes if time > when and volts == 0.0) - when


class Scene:
    """A server, a program under guard, and what became of them."""

    def __init__(self, folder: Path, strict: bool = False, address: str | None = None) -> None:
        """`address`: of a server elsewhere, whose voltage is not seen from here."""
        self.bench = RecordingBench()
        self.server = NiDeviceServer(self.bench, CLOCK, strict_ownership=strict)
        self.is_ours = address is None
        self.report_path = folder / "guard.json"
        address = address or f"127.0.0.1:{self.server.listen(0)}"
        self.place = OutputPlace(
            address=address,
            output_channel="PCI6703/ao0",
            drive_channel="PCI6034E/ai2",
            limit_board_V=0.25,
        )
        self.settings = GuardSettings(
            boards="ni", place=self.place.as_dict(), report_path=str(self.report_path)
        )
        self.victim: subprocess.Popen[str] | None = None
        self.guard_pid = 0

    def run(self, ending: str, **settings) -> None:
        """Start the program and wait until the sheet is energised."""
        self.settings = dataclasses.replace(self.settings, **settings)
        self.victim = subprocess.Popen(
            [sys.executable, str(VICTIM), self.settings.to_json(), ending],
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=sys.platform != "win32",
        )
        self.guard_pid = int(self.hear("guard")[1])
        self.hear("energised")
        CLOCK.sleep_until(CLOCK.now() + 0.1)
        if self.is_ours:
            assert self.bench.volts == pytest.approx(0.2, abs=4e-4)

    def hear(self, word: str) -> list[str]:
        """The next line of the program that begins with this word."""
        for line in self.victim.stdout:
            if line.startswith(word):
                return line.split()
        pytest.fail(f"the program ended without '{word}'")

    def signal(self, number: int) -> float:
        """Send the program a signal; the time."""
        now = CLOCK.now()
        self.victim.send_signal(number)
        return now

    def report(self, patience_s: float = 6.0) -> dict:
        """What the guard has left, once it is there and the guard has ended."""
        until = CLOCK.now() + patience_s
        while CLOCK.now() < until:
            if self.report_path.exists() and self.report_path.read_text().endswith("}"):
                return json.loads(self.report_path.read_text())
            CLOCK.sleep_until(CLOCK.now() + 0.005)
        pytest.fail("the guard has left no report")

    def assert_safe_and_free(self) -> None:
        """0 V now and a while later, the guard gone, and both boards free for the next program."""
        CLOCK.sleep_until(CLOCK.now() + 0.15)
        assert self.bench.volts == 0.0
        assert not lives(self.guard_pid)
        connection = NiConnection(self.place.address)
        connection.open()
        assert connection.attach_task("labrig-output") is None
        assert connection.attach_task("labrig-input") is None
        connection.close()

    def end(self) -> None:
        if self.victim is not None:
            self.victim.kill()
            ended(self.victim)
            self.victim.stdout.close()
        until = CLOCK.now() + 6.0
        while self.guard_pid and lives(self.guard_pid) and CLOCK.now() < until:
            CLOCK.sleep_until(CLOCK.now() + 0.02)
        self.server.stop()


def lives(pid: int) -> bool:
    """Whether a process runs (a dead one that nobody has waited for does not)."""
    try:
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
    except (OSError, IndexError):
        return False


# Whole runs on a server that owns the tasks: tests/end_to_end/test_guard_of_a_run.py.
@pytest.fixture(params=few([False, True], True), ids=["server owns", "strict ownership"])
def scene(request, tmp_path):
    scene = Scene(tmp_path, strict=request.param)
    yield scene
    scene.end()


@pytest.fixture
def remote(tmp_path):
    scene = Scene(tmp_path)
    yield scene
    scene.end()


@pytest.mark.alone
def test_output_is_zero_after_the_process_is_killed(scene):
    scene.run("beat")
    killed = scene.signal(getattr(signal, "SIGKILL", signal.SIGTERM))
    report = scene.report()
    assert report["state"] == Safety.SAFE
    assert report["why"] == "the program has died"
    assert abs(report["read_back_V"]) < 0.05
    assert scene.bench.zeroed_after(killed) < AFTER_A_KILL_S
    scene.assert_safe_and_free()


@pytest.mark.alone
@posix
def test_output_is_zero_after_the_whole_process_group_is_killed(remote):
    remote.run("beat")
    killed = CLOCK.now()
    os.killpg(remote.victim.pid, signal.SIGKILL)
    assert remote.report()["state"] == Safety.SAFE
    assert remote.bench.zeroed_after(killed) < AFTER_A_KILL_S
    remote.assert_safe_and_free()


@pytest.mark.alone
@posix
def test_output_is_zero_after_the_process_is_stopped(scene):
    scene.run("beat")
    stopped = scene.signal(signal.SIGSTOP)
    report = scene.report()
    assert report["state"] == Safety.SAFE
    assert report["why"] == "the program hangs"
    assert scene.bench.zeroed_after(stopped) < AFTER_A_HANG_S
    scene.assert_safe_and_free()


@posix
def test_a_program_that_hangs_at_zero_volts_amid_a_run_is_reported(scene):
    scene.run("hang_at_zero", at_zero_limit_s=0.5)
    scene.hear("hanging")
    report = scene.report()
    assert report["why"] == "the program hangs"
    assert report["state"] == "safe"


@pytest.mark.alone
def test_output_is_zero_when_the_loop_hangs(scene):
    scene.run("hang")
    hung = float(scene.hear("hanging")[-1])
    assert scene.report()["why"] == "the program hangs"
    assert scene.bench.zeroed_after(hung) < AFTER_A_HANG_S
    scene.assert_safe_and_free()


def test_a_program_that_wakes_after_the_guard_has_acted_cannot_energise_again(remote):
    remote.run("hang")
    assert remote.report()["state"] == Safety.SAFE
    assert remote.hear("refused")[1] == "TaskGoneError"
    remote.assert_safe_and_free()


@pytest.mark.alone
def test_a_program_that_exits_without_a_word_is_as_good_as_dead(remote):
    remote.run("exit")
    exited = float(remote.hear("exiting")[-1])
    assert remote.report()["state"] == Safety.SAFE
    assert remote.bench.zeroed_after(exited) < AFTER_A_KILL_S
    remote.assert_safe_and_free()


@pytest.mark.alone
@posix
def test_a_child_that_holds_the_pipe_does_not_hide_the_programs_death(remote):
    remote.run("fork")
    remote.hear("forked")
    killed = remote.signal(signal.SIGKILL)
    report = remote.report()
    assert report["why"] == "the program has died"
    assert report["state"] == Safety.SAFE
    assert remote.bench.zeroed_after(killed) < AFTER_A_KILL_S
    remote.assert_safe_and_free()
    os.killpg(remote.victim.pid, signal.SIGKILL)


def test_a_program_that_energises_for_ever_is_ended(scene):
    scene.run("beat", time_under_voltage_s=1.0)
    began = CLOCK.now()
    report = scene.report()
    assert report["why"] == "the sheet was energised for too long in one run"
    assert report["state"] == Safety.SAFE
    assert scene.bench.zeroed_after(began) < 1.5
    scene.assert_safe_and_free()


def test_a_program_that_finishes_leaves_no_guard_and_no_report(remote):
    remote.run("finish")
    remote.hear("finished")
    assert remote.victim.wait(10) == 0
    assert not remote.report_path.exists()
    remote.assert_safe_and_free()


@pytest.mark.alone
@posix
def test_neither_signals_to_the_guard_end_it(remote):
    remote.run("beat")
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        os.kill(remote.guard_pid, number)
    CLOCK.sleep_until(CLOCK.now() + 0.15)
    assert lives(remote.guard_pid)
    assert remote.bench.volts == pytest.approx(0.2, abs=4e-4)
    killed = remote.signal(signal.SIGKILL)
    assert remote.report()["state"] == Safety.SAFE
    assert remote.bench.zeroed_after(killed) < AFTER_A_KILL_S


@posix
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP] if os.name == "posix" else [])
def test_a_guard_that_is_lost_stops_the_run(remote, number):
    remote.run("beat")
    lost = CLOCK.now()
    os.kill(remote.guard_pid, number)
    remote.hear("warned")
    remote.hear("zeroed")
    assert remote.bench.zeroed_after(lost) < 1.5
    if number == signal.SIGSTOP:
        os.kill(remote.guard_pid, signal.SIGKILL)


def test_a_server_that_refuses_zero_is_reported_as_unknown(remote):
    remote.run("beat")
    remote.server.faults.refuse["WriteAnalogScalarF64"] = -200324
    remote.signal(getattr(signal, "SIGKILL", signal.SIGTERM))
    report = remote.report(patience_s=15.0)
    assert report["state"] == Safety.UNKNOWN
    assert any("-200324" in failure for failure in report["failures"])


@pytest.mark.alone
def test_a_fault_that_passes_is_tried_again_until_zero_is_read(remote):
    remote.run("beat")
    remote.server.faults.refuse["WriteAnalogScalarF64"] = -200324
    killed = remote.signal(getattr(signal, "SIGKILL", signal.SIGTERM))
    CLOCK.sleep_until(CLOCK.now() + 0.5)
    remote.server.faults.refuse.clear()
    report = remote.report()
    assert report["state"] == Safety.SAFE
    assert remote.bench.zeroed_after(killed) < 1.5


def test_an_output_that_does_not_follow_is_reported_as_unknown(remote):
    remote.run("beat")
    remote.server.faults.stuck_outputs.add("PCI6703/ao0")
    remote.signal(getattr(signal, "SIGKILL", signal.SIGTERM))
    report = remote.report(patience_s=15.0)
    assert report["state"] == Safety.UNKNOWN
    assert report["read_back_V"] == pytest.approx(0.2, abs=1e-3)


@pytest.mark.alone
@posix
@pytest.mark.parametrize("strict", few([False, True]))
def test_the_simulated_server_as_a_program_is_made_safe_too(tmp_path, strict):
    """Everything in processes of its own, as on a rig."""
    more = ["--strict-ownership"] if strict else []
    command = [sys.executable, "-m", "sim_hardware", "serve", "--port", "0", "--wire", "ao0:ai2"]
    with subprocess.Popen([*command, *more], stdout=subprocess.PIPE, text=True) as serve:
        try:
            lines = iter(serve.stdout.readline, "ready\n")
            address = next(line for line in lines if line.startswith("grpc="))[5:].strip()
            scene = Scene(tmp_path, strict, address)
            scene.run("beat")
            killed = scene.signal(signal.SIGKILL)
            report = scene.report()
            assert CLOCK.now() - killed < AFTER_A_KILL_S  # read back and reported by then
            assert report["state"] == Safety.SAFE
            assert report["failures"] == []
            scene.end()
        finally:
            serve.terminate()


def test_a_guard_that_cannot_reach_the_boards_refuses_to_start():
    place = OutputPlace(
        address="127.0.0.1:9", output_channel="PCI6703/ao0", drive_channel="PCI6034E/ai2"
    )
    with pytest.raises(DeviceError, match=r"guard cannot start: .*no connection"):
        Guard.start(GuardSettings(boards="ni", place=place.as_dict()))


def test_a_module_of_the_users_named_drivers_does_not_keep_the_guard_from_starting(
    remote, tmp_path, monkeypatch
):
    (tmp_path / "drivers.py").write_text("raise RuntimeError('not the drivers that are meant')")
    monkeypatch.chdir(tmp_path)
    guard = Guard.start(remote.settings)
    guard.disarm()


def test_a_guard_that_was_killed_can_not_act(remote):
    guard = Guard.start(remote.settings)
    assert guard.can_act
    os.kill(guard.pid, signal.SIGKILL)
    guard._process.wait(5.0)
    assert not guard.can_act
    guard.disarm()


def test_a_guard_that_acts_by_itself_goes_on_when_a_program_asks_it_and_ends(remote):
    guard = Guard.start(remote.settings)
    remote.guard_pid = guard.pid
    remote.server.faults.refuse["WriteAnalogScalarF64"] = -200324
    guard.energised(True)
    CLOCK.sleep_until(CLOCK.now() + 1.0)  # without a beat: the program hangs
    asked = CLOCK.now()
    assert guard.act(0.5).state is Safety.UNKNOWN
    assert CLOCK.now() - asked < 1.0
    assert lives(guard.pid)
    guard.disarm()
    assert lives(guard.pid)
    remote.server.faults.refuse.clear()
    assert remote.report()["state"] == Safety.SAFE
    guard._process.wait(5.0)
    guard._reader.join(5.0)
    guard._process.stdout.close()


def test_disarming_while_energised_makes_the_guard_act(remote):
    """Nobody has confirmed 0 V, whatever the program believes."""
    guard = Guard.start(remote.settings)
    remote.guard_pid = guard.pid
    connection = NiConnection(remote.place.address)
    connection.open()
    output = NiVoltageOutput(connection, CLOCK, remote.place.output_channel, 0.25)
    output.open()
    guard.energised(True)
    output.write(0.2)
    guard.disarm()
    connection.close()
    assert guard.report is not None
    assert guard.report.state is Safety.SAFE
    remote.assert_safe_and_free()


@pytest.mark.parametrize("strict", [False, True])
def test_a_program_that_lost_its_connection_lets_the_guard_act(tmp_path, strict):
    scene = Scene(tmp_path, strict)
    connection = NiConnection(scene.place.address)
    connection.open()
    output = NiVoltageOutput(connection, CLOCK, scene.place.output_channel, 0.25)
    output.open()
    guard = Guard.start(scene.settings)
    guard.energised(True)
    output.write(0.2)
    connection.close()
    with pytest.raises(DeviceError, match=r"not open|closed"):
        output.close()
    report = guard.act()
    scene.guard_pid = guard.pid
    assert report.state is Safety.SAFE
    assert guard.report == report
    assert not guard.alive
    scene.assert_safe_and_free()
    guard.disarm()
    scene.end()


def test_the_dead_programs_tasks_are_taken_over_by_name(remote):
    """What `labrig safe` does when no guard was there."""
    remote.run("beat")
    os.kill(remote.guard_pid, getattr(signal, "SIGKILL", signal.SIGTERM))
    remote.victim.kill()
    ended(remote.victim)
    assert remote.bench.volts == pytest.approx(0.2, abs=4e-4)  # nobody has cleaned up
    connection = NiConnection(remote.place.address)
    connection.open()
    report = shut_down(connection, CLOCK, remote.place)
    connection.close()
    assert report.state is Safety.SAFE
    assert report.failures == ()
    remote.assert_safe_and_free()
    assert np.sign(remote.bench.volts) == 0


def test_what_a_makers_library_prints_is_no_message_of_the_guard(tmp_path):
    """Text without an end of line, before the first message, would be one with it."""
    (tmp_path / "acme_boards.py").write_text(
        "import os\nos.write(1, b'Acme SDK 2.1 ')\nraise OSError('no driver')\n"
    )
    info = tmp_path / "acme_boards-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme_boards\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[labrig.boards]\nacme = acme_boards:BOARDS\n")
    settings = GuardSettings(boards="acme", place={}, report_path=str(tmp_path / "guard.json"))
    path = os.pathsep.join([str(Path(__file__).parents[2]), str(tmp_path)])
    guard = subprocess.run(
        [sys.executable, "-m", "drivers.guard"],
        input=settings.to_json().encode() + b"\n",
        capture_output=True,
        env={**os.environ, "PYTHONPATH": path},
        timeout=60,
        check=False,
    )
    assert guard.stdout.startswith(b"failed there is no family of boards 'acme'")
    assert b"Acme SDK" in guard.stderr

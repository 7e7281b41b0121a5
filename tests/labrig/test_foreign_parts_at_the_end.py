"""Parts of other distributions that break their contract while the output is made safe."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from drivers.guard import __main__ as guard
from drivers.guard.rescuer import Rescuer
from drivers.guard.settings import GuardSettings
from drivers.interfaces import RealClock
from drivers.safe_shutdown import Safety, SafetyReport
from labrig.errors import LabrigWarning, NotReadyError, OutputUnknownError
from labrig.experiment import safety, watchdog
from labrig.experiment.rig.rig import Rig, opened
from labrig.experiment.safe_shutdown import SafeShutdown
from labrig.session.recording import disk
from sim_hardware.clock import VirtualClock

SAFE = SafetyReport(Safety.SAFE, 0.0, ())


class Device:
    """Notes its calls; those named `broken` raise what no contract knows."""

    channels = ("force", "current", "drive")

    def __init__(self, *broken: str, fault: type[BaseException] = RuntimeError) -> None:
        self.broken, self.fault = broken, fault
        self.calls: list[str] = []

    def __getattr__(self, name: str) -> Any:
        def call(*_arguments: object) -> Any:
            self.calls.append(name)
            if name in self.broken:
                raise self.fault(f"{name} is broken")

        setattr(self, name, call)
        return call


def rig_of(**devices: object) -> Rig:
    every: dict[str, object] = {name: Device() for name in ("boards", "output", "signals", "stage")}
    every |= {"camera": None, "trigger": None, "clock": VirtualClock(), **devices}
    limits = SimpleNamespace(safe_below_V=0.05)
    config = SimpleNamespace(limits=limits)
    rig = SimpleNamespace(
        **every,
        config=config,
        read_back=every["signals"],
    )
    return cast("Rig", rig)


@pytest.mark.parametrize("fault", [RuntimeError, SystemExit])
@pytest.mark.parametrize("broken", ["stage", "signals"])
def test_a_device_that_breaks_when_released_does_not_keep_the_output_open(
    broken: str, fault: type[BaseException]
) -> None:
    rig = rig_of(**{broken: Device("close", fault=fault)})
    with opened(rig):
        pass
    assert cast("Device", rig.output).calls == ["open", "close"]
    assert cast("Device", rig.boards).calls == ["open", "close"]


class Listed(Device):
    """Adds its name to a list when it is closed."""

    def __init__(self, name: str, closed: list[str]) -> None:
        super().__init__()
        self.close = lambda: closed.append(name)


def test_the_boards_are_released_before_every_other_device() -> None:
    closed: list[str] = []
    names = ("boards", "output", "signals", "trigger", "camera", "stage")
    with opened(rig_of(**{name: Listed(name, closed) for name in names})):
        pass
    assert closed == ["trigger", "signals", "output", "boards", "stage", "camera"]


@pytest.mark.parametrize("clock", [RealClock, VirtualClock])
@pytest.mark.parametrize("hung", ["camera", "stage", "signals"])
def test_a_device_that_never_closes_is_named_and_left_behind(
    hung: str, clock: type[RealClock | VirtualClock], monkeypatch: pytest.MonkeyPatch
) -> None:
    never = threading.Event()
    monkeypatch.setattr("labrig.experiment.rig.rig.CLOSE_S", 0.05)
    monkeypatch.setattr("sim_hardware.clock.STUCK_S", 0.05)
    monkeypatch.setattr(disk, "_left_behind", False)  # else the tests' own process ends early
    closed: list[str] = []
    names = ("boards", "output", "signals", "camera", "stage")
    devices = {name: Listed(name, closed) for name in names}
    devices[hung].close = lambda: never.wait(20.0)
    said = rf"warning: closing the {'inputs' if hung == 'signals' else hung} has not come to an end"
    with (
        pytest.warns(LabrigWarning, match=said) as told,
        opened(rig_of(clock=clock(), **devices)),
    ):
        pass
    never.set()
    assert [one.filename for one in told if one.category is LabrigWarning] == [__file__]
    assert sorted(closed) == sorted({*names} - {hung})


def test_an_output_that_never_closes_is_not_known_to_be_safe(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    never = threading.Event()
    monkeypatch.setattr("labrig.experiment.rig.rig.CLOSE_S", 0.05)
    monkeypatch.setattr(disk, "_left_behind", False)  # else the tests' own process ends early
    closed: list[str] = []
    output, stage = Device(), Listed("stage", closed)
    output.close = lambda: never.wait(20.0)
    rig = rig_of(clock=RealClock(), output=output, stage=stage)
    said = r"closing the output has not come to an end .*; switch the amplifier off"
    with (
        pytest.warns(LabrigWarning, match="closing the output has not"),
        pytest.raises(OutputUnknownError, match=said),
        opened(rig),
    ):
        pass
    never.set()
    assert closed == ["stage"]


def test_an_output_that_breaks_when_released_is_not_known_to_be_safe() -> None:
    rig = rig_of(output=Device("close"))
    said = "close is broken; switch the amplifier off"
    with pytest.raises(OutputUnknownError, match=said), opened(rig):
        pass


class Acting:
    """A watchdog that makes the output safe."""

    can_act = True

    def new_run(self) -> None: ...
    def run_over(self) -> None: ...

    def beat(self) -> None: ...

    def energised(self, on: bool) -> None: ...

    def act(self, _timeout_s: float) -> SafetyReport:
        return SAFE


@pytest.mark.parametrize("fault", [RuntimeError, SystemExit])
def test_boards_that_break_when_released_do_not_keep_the_guard_from_acting(
    fault: type[BaseException],
) -> None:
    rig = rig_of(
        output=Device("write", "open", "abandon", fault=fault),
        signals=Device("close", fault=fault),
        boards=Device("close", fault=fault),
    )
    shutdown = SafeShutdown(rig)
    shutdown.watchdog = Acting()
    assert shutdown.make_safe().is_safe


class Rescue:
    def __init__(self, *, breaks: int = 0, breaks_on: str = "make_safe") -> None:
        self.left, self.on, self.tries = breaks, breaks_on, 0

    def _do(self, name: str) -> None:
        if name == self.on and self.left:
            self.left -= 1
            raise RuntimeError(f"{name} is broken")

    def open(self) -> None:
        self._do("open")

    def make_safe(self, _patience_s: float, _on_held: object) -> SafetyReport:
        self.tries += 1
        self._do("make_safe")
        return SAFE if self.tries > 1 else SafetyReport(Safety.UNKNOWN, None, ())

    def close(self) -> None:
        self._do("close")


@pytest.mark.slow
@pytest.mark.parametrize("on", ["make_safe", "open", "close"])
def test_the_guard_tries_again_whatever_the_boards_code_raises(on: str) -> None:
    rescue = Rescue(breaks=1, breaks_on=on)
    settings = GuardSettings(boards="other", place={}, time_under_voltage_s=1.0)
    said: list[str] = []
    rescuer = Rescuer(settings, rescue, lambda: rescue, RealClock(), said.append)
    assert rescuer.act(lambda: None, lambda *_: "it hangs").is_safe
    assert rescue.tries == 2
    assert [json.loads(each)["why"] for each in said] == ["it hangs"]


@pytest.mark.slow
def test_the_guard_reports_boards_that_hang_and_makes_them_safe_beside_the_attempt_that_does(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, value in (("TELL_S", 0.05), ("REPORT_S", 0.2), ("HANGS_S", 0.3)):
        monkeypatch.setattr(f"drivers.guard.rescuer.{name}", value)
    never = threading.Event()

    class Hung(Rescue):
        def make_safe(self, _patience_s: float, _on_held: object) -> SafetyReport:
            never.wait(20.0)
            return SAFE

    good = Rescue()
    good.tries = 1
    path = tmp_path / "guard.json"
    settings = GuardSettings(boards="other", place={}, report_path=str(path))
    said: list[str] = []

    def send(facts: str) -> None:
        said.append(facts)
        path.unlink(missing_ok=True)  # the program has its report, and ends as it should

    rescuer = Rescuer(settings, Hung(), lambda: good, RealClock(), send)
    assert rescuer.act(lambda: None, lambda *_: "the boards hang").is_safe
    never.set()
    assert [json.loads(each)["state"] for each in said] == ["unknown", "safe"]
    lines = capsys.readouterr().err.splitlines()
    assert "NOT KNOWN TO BE SAFE yet: switch the amplifier off by hand" in lines[0]
    assert lines[1].endswith("; the guard keeps trying")
    assert "the output is safe" in lines[-1]
    assert not path.exists()


def test_the_guard_says_why_foreign_boards_cannot_be_guarded(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(guard, "_ignore_signals", lambda: None)
    monkeypatch.setattr(guard, "_keep_the_line", lambda: None)  # of this process
    monkeypatch.setattr(guard, "_first_line", lambda: '{"boards": "ni", "place": {}}')
    monkeypatch.setattr(guard, "_rescue_of", lambda *_: Rescue(breaks=1, breaks_on="open"))
    assert guard.main() == 3
    assert capfd.readouterr().out == "failed unexpected RuntimeError: open is broken\n"


@pytest.mark.parametrize("on", ["make_safe", "open"])
def test_labrig_safe_names_the_amplifier_when_the_boards_code_breaks(
    monkeypatch: pytest.MonkeyPatch, on: str
) -> None:
    monkeypatch.setattr(safety, "output_place", lambda _config: {})
    rescue = Rescue(breaks=1, breaks_on=on)
    family = SimpleNamespace(rescue=lambda *_: rescue)
    report = safety._made_safe(cast("Any", SimpleNamespace(family=family, boards_kind="other")))
    assert not report.is_safe
    assert f"{on} is broken" in report.text
    assert "switch the amplifier off" in report.text


def test_labrig_safe_survives_a_rescue_that_cannot_be_closed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(safety, "output_place", lambda _config: {})
    rescue = Rescue(breaks=1, breaks_on="close")
    rescue.tries = 1
    family = SimpleNamespace(rescue=lambda *_: rescue)
    assert safety._made_safe(
        cast("Any", SimpleNamespace(family=family, boards_kind="other"))
    ).is_safe


class Elsewhere:
    """A rig's config with boards whose place is no plain data."""

    is_simulated = False
    boards_kind = "other"
    boards = SimpleNamespace()
    limits = SimpleNamespace(time_under_voltage_s=1.0)


@pytest.mark.slow
def test_boards_that_the_guard_cannot_be_told_of_are_not_ready(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(watchdog, "output_place", lambda _config: {"place": object()})
    rig = cast("Rig", SimpleNamespace(config=Elsewhere(), interlock=None))
    said = r"cannot be told of the boards of \[other\]: TypeError"
    with pytest.raises(NotReadyError, match=said), watchdog.watched(rig, tmp_path / "s.h5"):
        pass


def test_an_interlock_that_breaks_is_not_ready_or_left_behind(tmp_path: Path) -> None:
    config = SimpleNamespace(is_simulated=True)
    rig = SimpleNamespace(config=config, interlock=Device("open"))
    with (
        pytest.raises(NotReadyError, match="RuntimeError: open is broken"),
        watchdog.watched(cast("Rig", rig), tmp_path / "s.h5"),
    ):
        pass
    rig.interlock = Device("close")
    with watchdog.watched(cast("Rig", rig), tmp_path / "s.h5"):
        pass
    assert rig.interlock.calls == ["open", "close"]

"""Parts of another distribution whose code raises: a sentence that names them, no traceback."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.config import RigConfig, parse_rig
from labrig.config.templates import write_templates
from labrig.experiment.replay import on_simulated_boards
from labrig.experiment.rig.channels import inputs_of

CODE = """
import threading
from dataclasses import dataclass, field

from drivers.boards.contract import BoardFamily, BoardInput
from drivers.boards.ni.family import BOARDS as NI
from drivers.boards.simple import SimpleBoard, SimpleSettings, simple_family
from drivers.cameras.contract import CameraKind, CameraSettings
from drivers.force_sensors.contract import ForceSensorKind
from drivers.positioners.contract import PositionerKind


def broken(*arguments):
    raise KeyError("no such thing")


@dataclass(frozen=True, kw_only=True)
class Settings:
    level: int = field(default=0, metadata={"description": "of it"})

    def __post_init__(self):
        if self.level > 9:
            raise TypeError("too high")


CAMERA = CameraKind(kind="broken", help="a camera", settings=CameraSettings, make=broken,
                    prefix="broken:")
STAGE = PositionerKind(kind="broken", help="a stage", settings=Settings, make=broken)


class Shut:
    def __init__(self, *around):
        pass

    def open(self):
        broken()

    def move_to(self, position_m):
        return True

    def position(self):
        return None

    def close(self):
        pass


SHUT = PositionerKind(kind="shut", help="a stage", settings=Settings, make=Shut)
NO_STAGE = PositionerKind(kind="none", help="a stage", settings=Settings, make=lambda *_: None)
NO_CAMERA = CameraKind(kind="none", help="a camera", settings=CameraSettings, prefix="none:",
                       make=lambda *_: None)
NO_METER = ForceSensorKind(kind="none", help="a meter", settings=Settings, make=Shut)
METER = ForceSensorKind(kind="broken", help="a meter", settings=Settings, make=broken)


@dataclass(frozen=True, kw_only=True)
class Boards:
    address: str = "here"
    sample_rate_hz: float = 1000.0


def family(**other):
    calls = {"connect": broken, "inputs": lambda _: NI.inputs(NI.settings()),
             "output_place": broken, "rescue": broken} | other
    return BoardFamily(kind="pico", help="boards", settings=Boards, **calls)


class Gone(SimpleBoard):
    def __init__(self, settings):
        pass

    open = write = start = read = stop = broken

    def close(self):
        pass


@dataclass(frozen=True, kw_only=True)
class Here(SimpleSettings):
    address: str = "here"


GONE = simple_family(kind="pico", help="boards", settings=Here, board=Gone)
UNCONNECTED = family()
def never(*arguments):
    threading.Event().wait(60)


DEAF = family(connect=never, rescue=never)
UNWIRED = family(inputs=lambda _: (BoardInput("force", "a/1", 1.0),))
UNKNOWN = family(inputs=broken)
"""
POINTS = """
[labrig.cameras]
broken = broken_parts:CAMERA
none = broken_parts:NO_CAMERA
[labrig.positioners]
broken = broken_parts:STAGE
shut = broken_parts:SHUT
none = broken_parts:NO_STAGE
[labrig.force_sensors]
broken = broken_parts:METER
none = broken_parts:NO_METER
[labrig.boards]
gone = broken_parts:GONE
unconnected = broken_parts:UNCONNECTED
unwired = broken_parts:UNWIRED
deaf = broken_parts:DEAF
unknown = broken_parts:UNKNOWN
"""
Check = Callable[..., tuple[int, str]]


@pytest.fixture
def check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Check:
    """`labrig check` of the shipped rig with other lines; its code and what it says."""
    site = tmp_path / "site"
    info = site / "broken_parts-2.0.dist-info"
    info.mkdir(parents=True)
    (site / "broken_parts.py").write_text(CODE)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken-parts\nVersion: 2.0\n")
    (info / "entry_points.txt").write_text(POINTS)
    monkeypatch.syspath_prepend(str(site))
    monkeypatch.delitem(sys.modules, "broken_parts", raising=False)
    write_templates(tmp_path / "rig", simulated=True)
    rig = tmp_path / "rig" / "rig.toml"

    def checked(
        *others: tuple[str, str], boards: str = "", tables: str = "", run_it: bool = False
    ) -> tuple[int, str]:
        text = rig.read_text().split("[simulated]")[0]
        if boards:
            head, _, rest = text.partition("[ni]")
            text = f"{head}[{boards}]\n" + rest[rest.index("[amplifier]") :]
        for old, new in others:
            assert old in text
            text = text.replace(old, new)
        rig.write_text(text + tables)
        files = [str(rig.parent / name) for name in ("rig.toml", "protocol.toml", "sheet.toml")]
        session = str(tmp_path / "session.h5")
        code = run(["run", *files, "-o", session, "--yes"] if run_it else ["check", str(rig)])
        return code, " ".join(capsys.readouterr().err.split())

    return checked


LOCAL = ('address = "simulated"', 'address = "127.0.0.1:9"')
SEEN = ('source = "simulated"', "source = 0")


def test_a_camera_that_cannot_be_made_is_named(check: Check) -> None:
    code, said = check(LOCAL, ('source = "simulated"', 'source = "broken:1"'))
    assert "the camera 'broken' of broken-parts 2.0 cannot be used: KeyError" in said
    assert code == 3


def test_a_stage_that_cannot_be_made_is_named(check: Check) -> None:
    code, said = check(LOCAL, SEEN, ('"manual"', '"broken"'))
    assert "the positioner 'broken' of broken-parts 2.0 cannot be used: KeyError" in said
    assert code == 3


def test_a_camera_that_is_not_returned_is_named(check: Check) -> None:
    code, said = check(LOCAL, ('source = "simulated"', 'source = "none:1"'))
    assert "the camera 'none' of broken-parts 2.0 cannot be used: its make returned None" in said
    assert code == 3


def test_a_stage_that_is_not_returned_is_named(check: Check) -> None:
    code, said = check(LOCAL, SEEN, ('"manual"', '"none"'))
    assert (
        "the positioner 'none' of broken-parts 2.0 cannot be used: its make returned None, which "
        "has no open, move_to, position, close"
    ) in said
    assert code == 3


def test_a_meter_without_a_method_is_named(check: Check) -> None:
    code, said = check(LOCAL, SEEN, tables='[force_sensor]\nkind = "none"\n')
    assert "the force sensor 'none' of broken-parts 2.0 cannot be used: its make returned" in said
    assert "which has no read_force, tare, range_N" in said
    assert code == 3


@pytest.mark.slow
def test_a_stage_that_cannot_be_opened_is_named_with_the_place_in_its_code(check: Check) -> None:
    code, said = check(('"manual"', '"shut"'))
    where = "in broken-parts 2.0 (broken_parts.py, line 14)"
    assert f"opening the stage failed: KeyError: 'no such thing', {where}" in said
    assert code == 3


def test_a_meter_that_cannot_be_made_is_named(check: Check) -> None:
    code, said = check(LOCAL, SEEN, tables='[force_sensor]\nkind = "broken"\n')
    assert "the force sensor 'broken' of broken-parts 2.0 cannot be used: KeyError" in said
    assert code == 3


def test_boards_that_cannot_be_connected_are_named(check: Check) -> None:
    code, said = check(SEEN, boards="unconnected")
    assert "the family of boards 'unconnected' of broken-parts 2.0 cannot be used: KeyErr" in said
    assert "in broken-parts 2.0 (broken_parts.py, line 14)" in said
    assert code == 3


def test_a_board_that_cannot_be_opened_is_named_with_the_place_in_its_code(check: Check) -> None:
    code, said = check(SEEN, boards="gone")
    where = "in broken-parts 2.0 (broken_parts.py, line 14)"
    assert "no connection to pico at here: KeyError: 'no such thing'; check its power" in said
    assert where in said
    assert code == 3


def test_boards_without_a_needed_input_are_refused(check: Check) -> None:
    code, said = check(SEEN, boards="unwired")
    assert "the boards of [unwired] have no input current, drive" in said
    assert code == 2


def test_boards_that_cannot_say_their_inputs_are_refused(check: Check) -> None:
    code, said = check(SEEN, boards="unknown")
    assert "its part failed with KeyError: 'no such thing'" in said
    assert code == 2


def test_settings_that_their_part_cannot_read_are_refused(check: Check) -> None:
    code, said = check(LOCAL, SEEN, tables='[force_sensor]\nkind = "broken"\nlevel = 12\n')
    assert "force_sensor" in said
    assert "its part failed with TypeError: too high" in said
    assert code == 2


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGTERM that can be handled")
def test_boards_that_never_answer_are_left_by_a_second_signal(
    check: Check, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("protocols.execution.stop.DEAF_S", 0.2)
    ended = threading.Event()

    def press() -> None:
        while not ended.wait(0.5):
            if signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
                os.kill(os.getpid(), signal.SIGTERM)

    pressing = threading.Thread(target=press)
    pressing.start()
    try:
        code, said = check(SEEN, boards="deaf", run_it=True)
    finally:
        ended.set()
        pressing.join()
    assert (code, said.endswith("labrig: stopped.")) == (4, True), said


def test_further_channels_of_other_boards_are_replayed_by_inputs_of_the_default_ones(
    check: Check,
) -> None:
    del check  # installs the parts
    channels = "".join(
        f'[channels.{name}]\ninput = "{name}"\nquantity = "heat"\nunit = "degC"\n'
        for name in ("hot", "cold")
    )
    text = '[unconnected]\naddress = "here"\n[load_cell]\ncalibration = "cell.toml"\n'
    rig = parse_rig(text + channels, "rig.toml")
    assert isinstance(rig, RigConfig)
    inputs = inputs_of(on_simulated_boards(rig))
    assert [(each.name, each.terminal) for each in inputs[3:]] == [
        ("hot", "PCI6034E/ai3"),
        ("cold", "PCI6034E/ai4"),
    ]

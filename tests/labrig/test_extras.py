"""Extras with runs of their own in protocol.toml, and what a plan says of them."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.config import EXTRAS, RigConfig, parse_protocol, parse_rig
from labrig.config.templates import template_text, write_templates
from labrig.errors import BadInputError
from labrig.experiment.next_measurement.dynamic_needs import not_determined
from labrig.experiment.plan import load_plan
from labrig.experiment.preflight import estimated_size
from labrig.session.format.extras import extras_of, with_extras, without_extras
from protocols import free_shapes_in_words
from protocols.extras.chirp import Chirp
from protocols.extras.free_shapes import FreeShapes
from protocols.extras.load_cell_step import LoadCellStep
from protocols.extras.release import Release

PLACES = """
[pulse_train]
zero_readings = 2
readings_per_voltage = 2
[[places]]
configuration = "long"
positions_mm = [5, 15]
"""
MOVING = "[extras.free_shapes]\nmoving = true\n[analysis]\ndynamic = true\n"
ALL = "[extras]\nrelease = true\nload_cell_step = true\n[extras.chirp]\nend_hz = 4\n"


def config(extras: str = "", places: str = PLACES):
    return parse_protocol(places + extras, "protocol.toml")


def schedule_of(extras: str):
    return config(extras).schedule("protocol.toml")


def rig(without: str = "", rate_hz: float = 1000.0) -> RigConfig:
    text = template_text("rig_simulated.toml").replace("1000.0", f"{rate_hz:g}")
    start = text.find(f"[{without}]")
    if start >= 0:
        text = text[:start] + text[text.index("\n[", start) + 1 :]
    found = parse_rig(text, "rig.toml")
    assert isinstance(found, RigConfig)
    return found


# -------------------------------------------------------------------------------- protocol.toml


def test_an_extra_is_true_or_a_table():
    assert config(ALL).extras.extras().added == (
        Chirp(end_hz=4.0),
        FreeShapes(),  # of mode "default"
        LoadCellStep(),
        Release(),
    )
    assert config("[extras]\nfree_shapes = false\n").extras.extras().added == ()
    assert config('[extras]\nmode = "paper"\n').extras.extras().added == ()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[extras.chirp]\nend_hz = 50\n", r"\[extras\] chirp: 50 Hz written every 0.01 s is less"),
        ("[extras.chirp]\nende_hz = 5\n", r"\[extras.chirp\] ende_hz is not a known key; did you"),
        ("[extras.release]\nhold_s = 0\n", r"\[extras.release\] hold_s = 0.*greater than 0"),
        ("[extras]\nrelase = true\n", r"\[extras\] relase is not a known key; did you mean relea"),
        ("[extras]\nrelease = 3\n", r"\[extras\] release = 3: should be true or false"),
        (
            '[extras]\nmode = "paper"\nrelease = true\n',
            'mode "paper" has no extras; remove release',
        ),
    ],
)
def test_a_fault_of_an_extra_is_one_sentence(text, says):
    with pytest.raises(BadInputError, match=says) as told:
        config(text)
    assert str(told.value).count("\n") == 0


WAIT = '''
"""Nothing for a while, with all frames."""

from dataclasses import dataclass
from typing import ClassVar

from protocols.extras.contract import Extra, ExtraRun
from protocols.kinds.fields import duration
from protocols.planning.builder import Builder


@dataclass(frozen=True, kw_only=True)
class Wait(Extra):
    """Nothing for a while."""

    name: ClassVar[str] = "wait"
    wait_s: float = duration(2.0, "how long")

    def runs(self, protocol, positions_m):
        run = Builder()
        run.step(0.0, self.wait_s)
        yield ExtraRun(parts=run.finish(), keep_all_frames=True)
'''


def test_an_extra_of_another_distribution_is_a_key_like_the_rest(tmp_path, monkeypatch):
    (tmp_path / "wait_extra.py").write_text(WAIT)
    info = tmp_path / "wait_extra-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: wait-extra\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[labrig.extras]\nwait = wait_extra:Wait\n")
    monkeypatch.syspath_prepend(tmp_path)
    try:
        assert EXTRAS.origins() == {"wait": "wait-extra 1.0"}
        runs = schedule_of("[extras]\nfree_shapes = false\n[extras.wait]\nwait_s = 5\n").runs
        assert [(each.extra, each.duration_s) for each in runs if each.extra] == [("wait", 5.0)]
    finally:
        sys.modules.pop("wait_extra", None)


# ---------------------------------------------------------------------------- what the plan says


def test_the_plan_says_how_long_free_shapes_have_been_at_rest():
    assert free_shapes_in_words(schedule_of("")) == "long: at 0 V after 3 s, none under voltage"
    settled = schedule_of("[extras.free_shapes]\nsettled_s = 6\n")
    assert free_shapes_in_words(settled) == "long: at 0 V after 3 s, under voltage after 6 s"
    early = schedule_of("[extras.free_shapes]\nsettled_s = 4\n")
    assert free_shapes_in_words(early).endswith("after 4 s (the sheet may still swing)")
    moving = schedule_of("[extras.free_shapes]\nmoving = true\nrest_s = 4\n")
    assert free_shapes_in_words(moving) == (
        "long: at 0 V after 4 s, under voltage after 0.5 s (the sheet may still swing)"
    )
    assert free_shapes_in_words(schedule_of("[extras]\nfree_shapes = false\n")) == ""


@pytest.mark.parametrize(
    ("extras", "says"),
    [
        ("", []),  # nobody asks for a dynamic fit
        ("[extras]\nrelease = true\n", []),
        ("[analysis]\ndynamic = true\n", ["mass and loss of the sheet 'long'"]),
        ("[extras]\nload_cell_step = true\n", ["add [extras] release = true"]),
        (MOVING, ["mass and loss"]),
        (
            MOVING + "[camera]\nkeep_all_frames = true\n",
            [],
        ),
        ("[extras]\nrelease = true\n[camera]\nframe_rate_hz = 12\n", ["12 frames/s are too slow"]),
    ],
)
def test_the_plan_warns_of_what_a_dynamic_fit_would_not_know(extras, says):
    protocol = config(extras)
    found = not_determined(protocol, protocol.schedule("protocol.toml"))
    assert len(found) == len(says)
    assert all(part in text for part, text in zip(says, found, strict=True))


def test_a_free_sheet_alone_tells_ratios_only():
    protocol = config("[extras]\nrelease = true\n", PLACES.replace("[5, 15]", "[]"))
    (text,) = not_determined(protocol, protocol.schedule("protocol.toml"))
    assert "only as ratios without a force" in text


def test_the_rig_is_asked_for_what_it_records():
    protocol = config("[analysis]\ndynamic = true\n")
    schedule = protocol.schedule("protocol.toml")
    assert not_determined(protocol, schedule, rig()) == not_determined(protocol, schedule)
    (text,) = not_determined(protocol, schedule, rig(without="camera"))
    assert "not determined without a camera" in text
    slow, _ = not_determined(protocol, schedule, rig(rate_hz=100.0))
    assert "100 samples/s" in slow


def test_plan_prints_the_warning_and_the_time_under_voltage(tmp_path, capsys):
    path = tmp_path / "protocol.toml"
    path.write_text(PLACES + "[extras]\nload_cell_step = true\n[extras.chirp]\nend_hz = 4\n")
    assert run(["plan", str(path)]) == 0
    out, err = capsys.readouterr()
    # 3 measurements (one from the other side) of 6 pulses of 0.6 s, and the sweep of 12 s
    assert "22.8 s of it under voltage" in out
    assert "free shapes: 2 zero" in out
    assert "add [extras] release = true" in err


def test_plan_speaks_of_one_run(tmp_path, capsys):
    path = tmp_path / "protocol.toml"
    one = '[[places]]\nconfiguration = "long"\npositions_mm = [0]\n'
    path.write_text(one + '[pulse_train]\n[extras]\nmode = "paper"\n')
    assert run(["plan", str(path)]) == 0
    assert "\n1 run: " in capsys.readouterr().out


# -------------------------------------------------------------------------------------- the rig


@pytest.fixture
def folder(tmp_path):
    write_templates(tmp_path, simulated=True)
    (tmp_path / "protocol.toml").write_text(PLACES + ALL)
    return tmp_path


def plan_in(folder: Path):
    return load_plan(*(folder / name for name in ("rig.toml", "protocol.toml", "sheet.toml")))


def test_a_release_without_a_camera_is_refused_with_one_sentence(folder):
    text = (folder / "rig.toml").read_text()
    start = text.index("[camera]")
    (folder / "rig.toml").write_text(text[:start] + text[text.index("[stage]") :])
    with pytest.raises(BadInputError, match=r"release is recorded by a camera, and the rig has"):
        plan_in(folder)


def test_an_extra_beyond_the_limits_of_the_rig_is_refused(folder):
    (folder / "protocol.toml").write_text(PLACES + "[extras.chirp]\namplitude_V = 2.6\n")
    with pytest.raises(BadInputError, match=r"beyond the limit of ±2.5 V"):
        plan_in(folder)


def test_the_frames_of_a_release_are_in_the_estimate_of_the_files_size(folder):
    plan = plan_in(folder)
    frames = tuple(replace(each, keep_all_frames=False) for each in plan.schedule.runs)
    without = replace(plan, schedule=replace(plan.schedule, runs=frames))
    more = estimated_size(plan, 1000) - estimated_size(without, 1000)
    assert more == pytest.approx(1000 * 5.1 * 25, rel=0.01)


# -------------------------------------------------------------------------------------- the file


def test_the_schedule_in_the_file_is_one_that_older_programs_read():
    schedule = schedule_of(ALL)
    plain = json.loads(json.dumps(extras_of(schedule)))
    former = without_extras(schedule)
    assert with_extras(former, plain) == schedule
    assert {each.extra for each in former.runs} == {""}
    assert extras_of(former) == {}

"""A whole session becomes measurements: conditions, curves, series, warnings."""

from __future__ import annotations

import errno
import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from labrig.analysis import analyze, measure, measure_curves
from labrig.analysis.analyze import inputs_of
from labrig.analysis.curves import mean_image
from labrig.config import parse_sheet
from labrig.errors import BadInputError
from labrig.report.data.findings import measured
from labrig.session import load_measurements, open_session, verify
from labrig.vision import Optics
from protocols import Extras, Place, make_schedule
from protocols.execution import events as ev
from protocols.extras.free_shapes import FreeShapes
from protocols.kinds.pulse_train import PulseTrain
from tests.cases import few
from tests.labrig.analysis.analysed import (
    OPTICS,
    bent,
    change,
    record_with,
    with_pictures,
)
from tests.labrig.session.measured import same
from tests.labrig.session.session_recording import SENSITIVITY_V_PER_N, SHEET, small_schedule

TRAIN = PulseTrain(zero_readings=2, readings_per_voltage=2)


def curvature(voltage_V, _reading):
    return 10.0 + 5.0 * voltage_V


@pytest.fixture(scope="module")
def pictured(tmp_path_factory):
    """One run at 5 mm whose frames show a sheet of known curvature."""
    path = tmp_path_factory.mktemp("pictured") / "s.h5"
    schedule = make_schedule(TRAIN, [Place("long", (0.005,))])
    return record_with(path, schedule, with_pictures(curvature), frame_shape=(260, 360))


def distance_m(curve, wanted):
    """Distance of each point of a curve from the nearest of many points."""
    points = np.stack([curve.x_m, curve.y_m], axis=1)
    return np.min(np.hypot(*(points[:, None] - wanted[None]).transpose(2, 0, 1)), axis=1)


@pytest.mark.slow
def test_how_well_the_camera_is_calibrated_goes_with_the_measurements(pictured, tmp_path):
    path = tmp_path / "s.h5"
    shutil.copy(pictured, path)
    with open_session(path) as session:
        given = inputs_of(session)
    sure = given.optics.model_copy(update={"px_per_mm_sigma": 0.003, "origin_sigma_px": 0.06})
    camera = replace(given, optics=sure).camera_uncertainty([])
    assert camera.scale == pytest.approx(0.003 / 6.0)
    assert camera.origin_m == pytest.approx(0.06 / 6000.0)
    found = analyze(path)
    assert 0.0 < found.camera.curve_m < 1e-5  # which every extraction has
    assert found.camera.scale == 0.0  # optics.json states none
    assert load_measurements(path).camera == found.camera


@pytest.mark.slow
def test_conditions_hold_all_that_was_measured(tmp_path):
    path = record_with(tmp_path / "s.h5", small_schedule(), frame_shape=None)
    with open_session(path) as session:
        found = measure(session)
        begin_s = session.events[0].time_s
        second = session.runs[1]
    assert [(c.configuration, c.position_m, c.voltage_V) for c in found.conditions] == [
        (name, position, voltage)
        for name, position in (("long", 0.0), ("long", 0.005), ("short", 0.0))
        for voltage in (0.0, 2.0, -2.0)
    ]
    plus = found.conditions[4]
    assert [r.kind for r in plus.readings] == ["discarded", "kept", "kept"]
    assert [r.index for r in plus.readings] == [2, 4, 6]
    reading = plus.readings[0]
    assert reading.session_s == pytest.approx(second.time_zero_s - begin_s + reading.time_s)
    assert reading.wetted_s == pytest.approx(12.5 + reading.time_s)
    assert len(found.series) == 3
    assert found.warnings == ("The session was recorded without a camera; it has no curves.",)


@pytest.mark.slow
def test_extras_become_conditions_of_their_own_kind(tmp_path):
    extras = Extras(
        no_touch_zero=True,
        added=(FreeShapes(),),
        reversed_approach=True,
        remounts=1,
        dead_weights_N=(0.01,),
    )
    schedule = make_schedule(TRAIN, [Place("long", (0.0, 0.005))], extras=extras)
    with open_session(record_with(tmp_path / "s.h5", schedule, frame_shape=None)) as session:
        found = measure(session)
        purposes = [run.planned.purpose.value for run in session.runs]
    assert purposes.count("dead_weight") == 2
    free = [c for c in found.conditions if c.position_m is None]
    assert {r.kind for c in free for r in c.readings} == {"no_contact"}
    keys = [
        (c.configuration, c.position_m, c.voltage_V, c.mounting, c.approach, c.run)
        for c in found.conditions
    ]
    assert len(keys) == len(set(keys))
    again = [c for c in found.conditions if c.position_m == 0.005 and c.voltage_V == 2.0]
    assert [(c.mounting, c.approach, c.run) for c in again] == [
        (0, "up", 0),
        (0, "down", 1),
        (1, "up", 0),
    ]


@pytest.mark.thorough
@pytest.mark.slow
def test_a_load_cell_that_weighs_wrong_is_reported(tmp_path):
    extras = Extras(dead_weights_N=(0.01, 0.02))
    schedule = make_schedule(TRAIN, [Place("long", (0.0,))], extras=extras)

    def weigh(true_N_per_N):
        def load(event):
            load_N = schedule.runs[event.run].load_N
            if load_N is None:
                return event
            volts = event.block.volts.copy()
            volts[0] = load_N * true_N_per_N * SENSITIVITY_V_PER_N
            return replace(event, block=replace(event.block, volts=volts))

        return change(ev.SignalsArrived, load)

    right = record_with(tmp_path / "right.h5", schedule, weigh(1.001), frame_shape=None)
    wrong = record_with(tmp_path / "wrong.h5", schedule, weigh(1.1), frame_shape=None)
    with open_session(right) as session:
        assert len(measure(session).warnings) == 1  # no camera
    with open_session(wrong) as session:
        told = measure(session).warnings[1:]
    assert "dead weight of 10.000 mN as 11.000 mN" in told[0]
    assert len(told) == 2


def test_the_mean_of_images_is_their_mean_to_a_fraction_of_a_level():
    rng = np.random.default_rng(0)
    images = rng.integers(0, 256, (10, 5, 7), dtype=np.uint8)
    mean = mean_image(images, 255.0)
    assert mean.dtype == np.uint16
    np.testing.assert_allclose(mean, images.astype(float).mean(axis=0) * 257, atol=0.5)
    full = mean_image([np.full((2, 2), 4095, dtype=np.uint16)] * 3, 4095.0)
    assert (full == 65535).all()


@pytest.mark.slow
def test_curves_are_found_in_mean_images_and_frame_by_frame(pictured):
    optics, sheets = Optics.from_json(OPTICS), parse_sheet(SHEET, "sheet.toml")
    told = []
    with open_session(pictured) as session:
        found = measure_curves(
            session, optics, sheets, progress=lambda share, text: told.append((share, text))
        )
    assert [curves.voltage_V for curves in found] == [0.0, 2.0, -2.0]
    assert told[-1] == (1.0, "long, 5 mm")
    for curves in found:
        wanted = bent(curvature(curves.voltage_V, 0))
        assert curves.warnings == ()
        assert distance_m(curves.mean, wanted).max() < 20e-6
        for curve in curves.by_reading.values():
            assert distance_m(curve, wanted).max() < 40e-6
    assert [list(curves.by_reading) for curves in found] == [[0, 1], [2, 4, 6], [3, 5, 7]]


@pytest.mark.thorough
@pytest.mark.slow
def test_two_processes_find_the_same_as_one(tmp_path, monkeypatch):
    monkeypatch.setattr("labrig.analysis.curves.WORTH_PROCESSES_S", 0.0)
    schedule = make_schedule(TRAIN, [Place("long", (0.0, 0.005))])
    path = record_with(
        tmp_path / "s.h5", schedule, with_pictures(curvature), frame_shape=(260, 360)
    )
    with open_session(path) as session:
        assert same(measure(session, workers=1), measure(session, workers=2))


@pytest.mark.thorough
@pytest.mark.slow
def test_a_sheet_that_moved_between_frames_is_reported(tmp_path):
    schedule = make_schedule(TRAIN, [Place("long", (0.005,))])

    def wandering(voltage_V, reading):
        return 10.0 + (5.0 if reading in (0, 4) else -5.0)

    path = record_with(
        tmp_path / "s.h5", schedule, with_pictures(wandering), frame_shape=(260, 360)
    )
    with open_session(path) as session:
        told = measure(session).warnings
    assert any("the sheet moved" in text for text in told)


@pytest.mark.slow
def test_the_analysis_is_kept_in_the_session_and_can_be_made_again(pictured, tmp_path):
    path = shutil.copy(pictured, tmp_path / "s.h5")
    made = analyze(path)
    assert same(load_measurements(path), made)
    assert all(check.ok for check in verify(path))
    assert made.source == "s.h5"
    with open_session(pictured) as session:
        assert made.checksum == session.checksum
    zero = made.conditions[0]
    assert zero.curve is not None
    assert all(reading.curve is not None for reading in zero.readings)
    assert same(analyze(path), made)


def read_only(monkeypatch):
    """No file can be made beside a session."""
    opened = os.open

    def refusing(path, *arguments, **options):
        if str(path).endswith(".lock"):
            raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))
        return opened(path, *arguments, **options)

    monkeypatch.setattr(os, "open", refusing)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_session_in_an_archive_is_measured_and_nothing_is_kept_in_it(
    pictured, tmp_path, monkeypatch
):
    path = Path(shutil.copy(pictured, tmp_path / "s.h5"))
    before = path.read_bytes()
    told = []
    with monkeypatch.context() as patched:
        read_only(patched)
        found = measured(path, lambda *_: None, told.append, processes=1)
        with pytest.raises(BadInputError, match=r"s\.h5 cannot be changed"):
            analyze(path)
    said, *warned = told
    assert warned == [f"{path}: {text}" for text in found.warnings]
    assert "not analysed yet; analysing it now. The result is not kept: " in said
    assert "Read-only file system" in said
    assert path.read_bytes() == before
    assert same(found, analyze(path))


@pytest.mark.slow
def test_a_session_that_cannot_be_added_to_is_refused_before_the_work(tmp_path, monkeypatch):
    path = record_with(tmp_path / "s.h5", make_schedule(TRAIN, [Place("long", (0.0,))]))
    (tmp_path / "s.h5.lock").mkdir()  # in place of the file that says who writes

    def not_reached(*_, **__):
        pytest.fail("measured")

    monkeypatch.setitem(analyze.__globals__, "measure", not_reached)
    with pytest.raises(BadInputError, match=r"s\.h5 cannot be changed: s\.h5\.lock beside it"):
        analyze(path)


@pytest.mark.thorough
@pytest.mark.slow
def test_frames_without_a_sheet_are_reported_once_for_each_condition(tmp_path):
    path = record_with(tmp_path / "s.h5", make_schedule(TRAIN, [Place("long", (0.0,))]))
    with open_session(path) as session:
        found = measure(session)
    assert all(c.curve is None for c in found.conditions)
    assert len([text for text in found.warnings if "no curve in the mean image" in text]) == 3
    # counted from 1, as labrig show and labrig mark do
    assert any("no curve in 2 frames, as in that of reading 1: " in text for text in found.warnings)
    assert found.warnings[0].startswith("No image of the session shows a curve")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("texts", "said"),
    few(
        [
            ({"sheet.toml": SHEET}, "holds no load_cell.toml"),
            ({}, "holds no sheet.toml"),
            (
                {
                    "sheet.toml": SHEET.replace("[short]", "[other]"),
                    "load_cell.toml": "date = 2026-11-01\nsensitivity_V_per_N = 0.15",
                },
                r"no table \[short\], which run 3 needs",
            ),
            ({"sheet.toml": SHEET, "load_cell.toml": "date = 3"}, "load_cell.toml: .*date"),
        ]
    ),
)
def test_what_a_session_lacks_is_reported(tmp_path, texts, said):
    path = record_with(tmp_path / "s.h5", small_schedule(), texts=texts)
    with pytest.raises(BadInputError, match=said):
        analyze(path)
    assert list(tmp_path.iterdir()) == [path]

"""The dynamic model beside a run of the moving world: prediction, error, slow parameters."""

from __future__ import annotations

import os
import signal
import threading
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from labrig.model_file import save_model
from labrig.panel.live.event_stream import EventStream, Mailbox
from labrig.panel.live.strip_chart import BIN_S, PREDICTED, SIGNALS, StripChart, joined
from labrig.panel.live_model import live_model
from labrig.panel.live_model.live_model import LiveModel
from labrig.panel.live_model.running_error import OVER_S, RunningError, white_noise
from tests.labrig.moving_model import model
from tests.labrig.panel.moving_session import followed, moving_session

WAIT_S = 180.0  # whether it comes, not how soon: a live model steps back for all others


def until(holds):
    end_s = time.monotonic() + WAIT_S
    while not holds():
        assert time.monotonic() < end_s
        threading.Event().wait(0.02)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return moving_session(tmp_path_factory)


def written(path, **changes):
    """Write a model of the moving world's sheet."""
    save_model(model(load_cell=True, negative_ratio=0.8, **changes), path)
    return str(path)


@pytest.fixture
def model_file(tmp_path):
    return partial(written, tmp_path / "m.toml")


@pytest.fixture(scope="module")
def of_the_true_model(recorded, tmp_path_factory):
    """Its answers to the whole session."""
    return followed(recorded, written(tmp_path_factory.mktemp("true") / "m.toml"))


def errors(answers):
    """Running errors at the ends of the runs."""
    last = {a.motion["run"]: a.motion for a in answers if a.motion["state"] == "stopped"}
    return [last[run] for run in sorted(last)]


def last_estimate(answers):
    trace = [a.estimates for a in answers if a.estimates is not None][-1]
    return dict(zip(trace["columns"], trace["rows"][-1], strict=True))


@pytest.mark.slow
def test_the_true_model_predicts_force_and_shape_within_the_noise(of_the_true_model):
    found = errors(of_the_true_model)
    assert len(found) == 2
    for motion in found:
        # beside white noise: drift 0.05 mN, hum 0.03 mN, hysteresis, 1 % from set-up to set-up
        assert 0.03 < motion["noise_mN"] < 0.1
        assert motion["force_rms_mN"] < 1.5 * motion["noise_mN"]
        assert motion["shape_rms_mm"] < 0.15
    row = last_estimate(of_the_true_model)
    assert abs(row["B"] - 1) < max(3 * row["B_sigma"], 0.03)
    assert abs(row["moment"] - 1) < max(3 * row["moment_sigma"], 0.03)
    assert row["B_sigma"] < 0.03


@pytest.mark.thorough
@pytest.mark.slow
def test_a_stiffness_that_is_off_by_20_per_cent_shows_in_the_error_and_in_the_estimate(
    recorded, model_file, of_the_true_model
):
    right = errors(of_the_true_model)
    answers = followed(recorded, model_file(stiffness=1.2))
    wrong = errors(answers)
    assert wrong[0]["force_rms_mN"] > 1.5 * right[0]["force_rms_mN"]
    for good, bad in zip(right, wrong, strict=True):  # on the rolls the shape hardly shows it
        assert bad["shape_rms_mm"] > 1.1 * good["shape_rms_mm"]
    row = last_estimate(answers)
    assert 1 / row["B"] == pytest.approx(1.2, abs=0.05)
    assert abs(row["moment"] - 1) < 0.04


@pytest.mark.slow
def test_the_prediction_has_each_bin_of_the_signals_once(recorded, of_the_true_model):
    measured = np.concatenate(
        [strip.values[0] for _, strip, _ in recorded[2] if strip is not None and strip.run == 0]
    )
    strips = [a.strip for a in of_the_true_model if a.strip is not None and a.strip.run == 0]
    assert {strip.kind for strip in strips} == {PREDICTED}
    assert [strip.fresh for strip in strips] == [True] + [False] * (len(strips) - 1)
    predicted = np.concatenate([strip.values[0] for strip in strips])
    np.testing.assert_allclose(np.diff(predicted), BIN_S, atol=1e-5)
    np.testing.assert_allclose(predicted[-1], measured[-1], atol=1e-5)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_model_that_is_slow_skips_images_and_takes_signals_in_larger_pieces(
    recorded, model_file, of_the_true_model
):
    every = of_the_true_model
    late = []
    for first in range(0, len(recorded[2]), 6):
        part = recorded[2][first : first + 6]
        messages = [message for row in part for message in row[0]]
        strips = joined([row[1] for row in part if row[1] is not None])
        curves = [row[2] for row in part if row[2] is not None]
        late.append((messages, strips[-1] if strips else None, curves[-1] if curves else None))
    some = followed(recorded, model_file(), late)
    whole, parts = (
        np.concatenate([a.strip.values for a in found if a.strip is not None], axis=1)
        for found in (every, some)
    )
    first = min(np.flatnonzero(np.diff(found[0]) < 0)[0] for found in (whole, parts))  # of run 0
    assert first > 800
    np.testing.assert_allclose(parts[1, :first], whole[1, :first], atol=1e-4)
    row = last_estimate(some)
    assert abs(row["B"] - last_estimate(every)["B"]) < max(2 * row["B_sigma"], 0.03)


@pytest.mark.thorough
@pytest.mark.slow
def test_signals_from_before_the_run_do_not_end_the_prediction(recorded, model_file):
    rows = recorded[2][:200]
    at = next(k for k, (_, strip, _) in enumerate(rows) if strip is not None and strip.run == 0)
    messages, strip, curve = rows[at]
    early = replace(strip, values=strip.values.copy())
    early.values[0] -= 1.0
    assert early.values[0].max() < 0
    split = [*rows[:at], (messages, early, None), ([], strip, curve), *rows[at + 1 :]]
    answers = followed(recorded, model_file(), split)
    assert {a.motion["why"] for a in answers} == {""}
    assert answers[-1].motion["state"] == "following"


@pytest.mark.slow
def test_what_the_model_cannot_do_is_a_sentence(recorded, model_file, tmp_path):
    still = tmp_path / "still.toml"
    save_model(model(dynamic=False), still)
    for path, words in (
        (str(still), "knows the sheet at rest only"),
        (str(tmp_path / "gone.toml"), "gone.toml"),
        (None, ""),
    ):
        (motion,) = {str(a.motion["why"]) for a in followed(recorded, path, recorded[2][:100])}
        assert words in motion
        assert "Traceback" not in motion
    save_model(model(names=("short",)), still, force=True)
    whys = {a.motion["why"] for a in followed(recorded, str(still))}
    assert any("long" in why and why.endswith("goes on with the next run.") for why in whys)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_load_cell_that_moves_ends_the_prediction_of_its_run(recorded, model_file):
    rows = recorded[2]
    moves = {"type": "load_cell", "time_s": 5.0, "run": 0, "position_mm": 7.0}
    changed = [*rows[:125], ([*rows[125][0], moves], *rows[125][1:]), *rows[126:150]]
    answers = followed(recorded, model_file(), changed)
    assert "the load cell moves in this run" in answers[-1].motion["why"]
    assert answers[100].motion["state"] == "following"


def test_the_running_error_is_that_of_the_last_seconds():
    error = RunningError()
    assert (error.rms, error.mean) == (None, None)
    for k in range(100):
        error.add(0.5 * k, 3.0 if k < 50 else -4.0)
    error.add(50.0, float("nan"))
    assert (error.rms, error.mean) == (4.0, -4.0)
    assert OVER_S < 25
    noise = np.random.default_rng(1).normal(0, 0.3, 2000)
    assert white_noise(np.arange(2000) * 1e-3 + noise) == pytest.approx(0.3, rel=0.1)


# ------------------------------------------------------------------------ the process, and its end


@pytest.fixture
def panel_side(recorded, model_file, monkeypatch):
    """The panel's side on a stream, and what pages hear."""
    # Its process leaves the processor to all others, and would wait here for other tests.
    monkeypatch.setattr(live_model, "lower_priority", lambda _pid: None)
    plan, setup, rows = recorded
    stream, box = EventStream(), Mailbox(lambda: None)
    stream.join(box)
    live = LiveModel(stream)
    live.set_setup(setup)
    live.choose_model(Path(model_file()))
    heard = {"motion": [], "estimates": [], "strips": []}

    def hear():
        while (mail := box.take()) is not None:
            for message in mail.newest:
                if message["type"] in heard:
                    heard[message["type"]].append(message)
            if mail.strip is not None and mail.strip.kind == PREDICTED:
                heard["strips"].append(mail.strip)
        return heard

    def tell(first, last):
        for messages, strip, curve in rows[first:last]:
            for message in messages:
                stream.publish(message)
            if strip is not None:
                stream.publish_strip(strip)
            if curve is not None:
                stream.publish_newest(curve)

    stream.publish_story([plan])
    yield live, tell, hear
    live.close()


@pytest.mark.slow
def test_pages_hear_the_prediction_and_the_estimates(panel_side, recorded):
    _, tell, hear = panel_side
    tell(0, 200)
    until(lambda: hear()["motion"] and hear()["motion"][-1]["state"] == "following")
    tell(200, 400)
    until(lambda: hear()["estimates"] and hear()["strips"])
    assert hear()["strips"][-1].keys == ("force_mN", "current_mA")
    # A slow model skips images, and pages hear its newest answer only: images until one is drawn.
    more = iter(range(400, len(recorded[2])))

    def a_shape_is_heard():
        first = next(more, None)
        if first is not None:
            tell(first, first + 1)
            threading.Event().wait(0.2)  # five times as long as it lasted
        return any(m.get("shape") is not None for m in hear()["motion"])

    until(a_shape_is_heard)


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="needs signals")
@pytest.mark.parametrize(
    "number",
    [signal.SIGKILL, pytest.param(signal.SIGSTOP, marks=pytest.mark.thorough)],
    ids=["killed", "hung"],
)
def test_a_process_that_fails_is_a_sentence_and_begins_again(panel_side, monkeypatch, number):
    live, tell, hear = panel_side
    tell(0, 200)
    until(lambda: hear()["motion"] and hear()["motion"][-1]["state"] == "following")
    monkeypatch.setattr(live_model, "ANSWER_S", 1.0)
    os.kill(live._process.pid, number)
    began_s = time.monotonic()
    tell(200, 210)
    assert time.monotonic() - began_s < 0.5  # who publishes does not wait
    until(lambda: "The run goes on." in hear()["motion"][-1]["why"])
    monkeypatch.setattr(live_model, "ANSWER_S", WAIT_S)
    tell(210, 400)
    until(lambda: hear()["motion"][-1]["state"] == "following")


def test_what_is_not_taken_is_left_out_and_never_queued():
    stream = EventStream()
    box = live_model._RunMailbox(lambda: None)
    stream.join(box)
    values = np.zeros((5, 100), dtype=np.float32)
    for number in range(200):
        stream.publish_picture(({"type": "picture"}, b"x"))
        stream.publish_newest({"type": "curve", "frame": number})
        for kind in (SIGNALS, PREDICTED):
            stream.publish_strip(
                StripChart(run=0, keys=("drive_V", "force_mN"), values=values, kind=kind)
            )
    mail = box.take()
    assert [message["frame"] for message in mail.newest] == [199]
    assert (mail.strip.kind, mail.strip.values.shape[1]) == (SIGNALS, 6000)
    assert box.take() is None
    assert box.take_picture() is None

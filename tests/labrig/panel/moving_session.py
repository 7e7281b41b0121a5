"""A recorded session of the moving world, and what a model beside it says of it."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sim_hardware.world
from labrig.panel.live.curve_process import Finder
from labrig.panel.live.frames import image_of
from labrig.panel.live_model.beside_run import ModelAnswer, ModelBesideRun
from labrig.panel.replay.recording import Recording
from tests.end_to_end.small_rig import make_rig, run_rig
from tests.made_once import made_once

FRAME_S = 0.04
FOLLOWED = "followed.pickle"  # the search for curves takes seconds
PROTOCOL = """
moisten = false
[pulse_train]
zero_readings = 2
readings_per_voltage = 5
[[places]]
configuration = "long"
positions_mm = [5, 15]
[extras]
mode = "paper"
"""
MOVING = Path(sim_hardware.world.__file__).with_name("moving.toml").read_text()
Recorded = tuple[Any, Any, list[tuple[Any, Any, Any]]]


def moving_session(factory: pytest.TempPathFactory) -> Recorded:
    """The plan, the camera, and (messages, strip, curve) of each 40 ms."""
    folder = made_once(factory, "moving", _record_and_follow)
    recorded: Recorded = pickle.loads((folder / FOLLOWED).read_bytes())
    return recorded


def _record_and_follow(folder: Path) -> None:
    recording = Recording(run_rig(make_rig(folder, PROTOCOL, MOVING)), "session.h5")
    finder = Finder()
    finder.setup(recording.setup)
    rows, before_s = [], -1.0
    for at_s in np.arange(0.0, recording.duration_s + FRAME_S, FRAME_S).tolist():
        strip = recording.strip(before_s, at_s, fresh=False)
        picture = recording.picture(before_s, at_s)
        curve = None if picture is None else finder.curve(picture[0], image_of(*picture))
        rows.append((recording.between(before_s, at_s), strip, curve))
        before_s = at_s
    (folder / FOLLOWED).write_bytes(pickle.dumps((recording.plan, recording.setup, rows)))
    recording.close()


def followed(recorded: Recorded, path: str | None, rows: Any = None) -> list[ModelAnswer]:
    """All answers of a model to a session."""
    plan, setup, every = recorded
    beside = ModelBesideRun()
    beside.choose(path)
    beside.setup(setup)
    beside.take(plan)
    answers = []
    for messages, strip, curve in rows or every:
        for message in messages:
            beside.take(message)
        answers.append(beside.follow(strip, curve))
    return answers

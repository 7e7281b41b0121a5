"""A run with lost readings, measured again within the same session file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.analysis.analyze import measure
from labrig.panel.replay.recording import Recording
from labrig.session import open_session, recover, verify
from protocols.execution.operator import REPEAT
from sim_hardware.operator import SimulatedOperator
from tests.end_to_end.small_rig import PROTOCOL as TWO_PLACES
from tests.end_to_end.small_rig import labrig, make_rig, run_rig

pytestmark = pytest.mark.slow
PROTOCOL = TWO_PLACES.replace("[10, 20]", "[10]")
SATURATED = """
[[faults]]
what = "current_saturated"
from_s = 0.5
until_s = 2.0
since = "first_voltage"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A rig whose first run loses readings, and an operator who has it measured again."""
    with pytest.MonkeyPatch.context() as patch:
        ask = SimulatedOperator.ask
        patch.setattr(
            SimulatedOperator,
            "ask",
            lambda self, prompt: ask(self, prompt) and prompt.kind != REPEAT,
        )
        folder = make_rig(tmp_path_factory.mktemp("repeat") / "rig", PROTOCOL, SATURATED)
        run_rig(folder)
        yield folder


def test_the_file_has_both_runs_and_is_whole(folder: Path) -> None:
    path = folder / "session.h5"
    assert all(check.ok for check in verify(path))
    with open_session(path) as session:
        assert [run.planned.index for run in session.runs] == [0, 1, 2]
        first, repeat = session.run(0), session.run(2)
        assert repeat.planned.repeats == 0
        assert repeat.planned.position_m == first.planned.position_m
        assert repeat.completed
        assert repeat.readings["valid"].all()
        lost = first.readings[~first.readings["valid"]]
        logged = [event for event in session.events if event.kind == "lost"]
        assert len(lost) >= 2
        assert [event.reading for event in logged] == lost["index"].tolist()
        assert all("current input" in event.text for event in logged)
        asked = [event for event in session.events if event.subject == REPEAT]
        assert [(event.kind, event.text) for event in asked[1:]] == [("answered", "again")]
        kinds = [event.kind for event in session.events]
        mounts = [
            i for i, e in enumerate(session.events) if (e.kind, e.subject) == ("asked", "mount")
        ]
        assert mounts[0] < session.events.index(asked[0]) < mounts[1]  # before the other sheet
        assert kinds.count("run started") == 3
    assert labrig("run", "--resume", path) == 2  # nothing is left to do


def test_the_analysis_takes_it_as_the_position_measured_again(folder: Path) -> None:
    with open_session(folder / "session.h5") as session:
        found = measure(session, curves=False)
    runs = {
        (condition.configuration, round(1e3 * condition.position_m), condition.run)
        for condition in found.conditions
        if condition.position_m is not None
    }
    assert ("long", 10, 0) in runs
    assert ("long", 10, 1) in runs
    assert ("short", 10, 1) not in runs


@pytest.mark.thorough
def test_a_replay_repeats_it_too(folder: Path) -> None:
    again = folder / "replayed.h5"
    assert labrig("replay", folder / "session.h5", "-o", again) == 0
    with open_session(folder / "session.h5") as first, open_session(again) as second:
        assert [r.planned for r in first.runs] == [r.planned for r in second.runs]
        np.testing.assert_array_equal(
            first.run(2).signal_V("force"), second.run(2).signal_V("force")
        )
    assert [span.run for span in Recording(again, "replayed.h5").spans] == [0, 2, 1]


@pytest.mark.thorough
def test_it_survives_a_crash(folder: Path, tmp_path: Path) -> None:
    whole = folder / "session.h5"
    cut = tmp_path / "cut.h5"
    cut.write_bytes(whole.read_bytes())
    with h5py.File(cut, "r+") as file:
        file["session/outcome"][()] = b"running"
    report = recover(cut)
    assert report.output == tmp_path / "cut-recovered.h5"
    assert report.runs_completed == 3

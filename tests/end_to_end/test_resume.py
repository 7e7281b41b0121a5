"""`labrig run --resume`: what was complete is kept to the last bit, the rest is run."""

from __future__ import annotations

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.experiment.resume import resumed_plan
from labrig.session import open_session, verify
from protocols.execution.events import Outcome, OutputState
from tests.end_to_end.small_rig import OVERLOADED_IN_THE_SECOND_RUN, labrig, make_rig

pytestmark = pytest.mark.slow
PROTOCOL = """
[pulse_train]
zero_readings = 1
readings_per_voltage = 2
pulses_discarded = 1
[[places]]
configuration = "long"
positions_mm = [10, 15, 20]
[extras]
mode = "paper"
"""
FILES = ("rig.toml", "protocol.toml", "sheet.toml")


@pytest.fixture(scope="module")
def failed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a rig whose session failed in its second run; its world is sound again."""
    folder = make_rig(
        tmp_path_factory.mktemp("resume") / "rig", PROTOCOL, OVERLOADED_IN_THE_SECOND_RUN
    )
    (folder / "about.toml").write_text('title = "as it was begun"\n')
    with (folder / "rig.toml").open("a") as rig:
        rig.write('\n[watch]\naddress = "boards"\n[publish]\nbluesky = "documents.jsonl"\n')
    assert labrig("run", *(folder / f for f in FILES), "-o", folder / "s.h5") == 5
    (folder / "world.toml").write_text("seed = 1\n")
    (folder / "about.toml").write_text('title = "edited since"\n')
    with open_session(folder / "s.h5") as session:
        assert [run.completed for run in session.runs] == [True, False, False]
    return folder


def test_a_resumed_session_is_whole_and_keeps_what_was_complete(failed: Path) -> None:
    before = (failed / "s.h5").read_bytes()
    assert labrig("run", "--resume", failed / "s.h5") == 0
    assert (failed / "s.h5").read_bytes() == before
    path = failed / "s-resumed.h5"
    assert all(check.ok for check in verify(path))
    with open_session(failed / "s.h5") as old, open_session(path) as new:
        assert new.outcome is Outcome.COMPLETED
        assert new.output_state is OutputState.SAFE
        assert [run.completed for run in new.runs] == [True] * 3
        assert new.identifier != old.identifier
        assert new.about.title == old.about.title == "as it was begun"
        first = new.events[0]
        assert (first.kind, old.identifier in first.text) == ("resumed", True)
        assert first.text.endswith("taken there: runs 1")  # counted as labrig show counts
        kept, copied = old.runs[0], new.runs[0]
        for channel in old.channels:
            np.testing.assert_array_equal(kept.signal_V(channel), copied.signal_V(channel))
        for name in kept.readings.dtype.names:
            if name == "time_s":
                np.testing.assert_allclose(kept.readings[name], copied.readings[name], atol=1e-9)
            else:
                np.testing.assert_array_equal(kept.readings[name], copied.readings[name])
        assert kept.frame_count == copied.frame_count > 0
        for row in range(kept.frame_count):
            np.testing.assert_array_equal(kept.image(row), copied.image(row))
        np.testing.assert_allclose(kept.frame_column("time"), copied.frame_column("time"))
        np.testing.assert_array_equal(kept.writes["sheet_V"], copied.writes["sheet_V"])
        # In the clock of the new session the old run comes before the new ones.
        zeros_s = [run.time_zero_s for run in new.runs]
        assert zeros_s == sorted(zeros_s)
        assert zeros_s[0] >= first.time_s


def test_files_that_the_session_names_are_beside_it_and_none_is_written(
    failed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Wherever it is resumed: what a file from elsewhere names must not be written to."""
    with open_session(failed / "s.h5") as session:
        rig = resumed_plan(session).rig
    assert rig.watch is not None
    assert rig.watch.token == failed / "watch.token"
    published = (failed / "documents.jsonl").read_bytes()
    monkeypatch.chdir(tmp_path)
    assert labrig("run", "--resume", failed / "s.h5", "-o", "whole.h5") == 0
    assert labrig("replay", failed / "s.h5", "-o", "again.h5") == 5  # as it ended then
    assert {path.name for path in tmp_path.iterdir()} == {"whole.h5", "again.h5"}
    assert (failed / "documents.jsonl").read_bytes() == published


@pytest.mark.thorough
def test_the_times_of_all_readings_count_from_the_first_session_s_start(
    failed: Path, tmp_path: Path
) -> None:
    path = tmp_path / "whole.h5"
    assert labrig("run", "--resume", failed / "s.h5", "-o", path) == 0
    with open_session(path) as session:
        began_s = session.events[0].time_s
        times = [run.time_zero_s - began_s + run.readings["time_s"] for run in session.runs]
    with h5py.File(path) as file:
        np.testing.assert_allclose(file["session/data/time_s"][()], np.concatenate(times))


@pytest.mark.thorough
def test_verify_says_where_readings_have_no_time_in_the_table_of_all(
    failed: Path, tmp_path: Path
) -> None:
    path = tmp_path / "old.h5"
    shutil.copy(failed / "s.h5", path)
    assert "times" not in [check.name for check in verify(path)]
    with h5py.File(path, "r+") as file:
        file["session/data/time_s"][:2] = np.nan
    (check,) = [check for check in verify(path) if check.name == "times"]
    assert check.word == "warning"
    assert check.found.startswith("2 of ")


@pytest.mark.thorough
def test_a_resumed_session_that_fails_can_be_resumed_itself(failed: Path, tmp_path: Path) -> None:
    folder = tmp_path / "rig"
    shutil.copytree(failed, folder)
    (folder / "world.toml").write_text(OVERLOADED_IN_THE_SECOND_RUN)
    assert labrig("run", "--resume", folder / "s.h5", "-o", folder / "second.h5") == 5
    with open_session(folder / "second.h5") as session:
        assert [run.completed for run in session.runs] == [True, True, False]
    (folder / "world.toml").write_text("seed = 1\n")
    assert labrig("run", "--resume", folder / "second.h5", "-o", folder / "third.h5") == 0
    with open_session(folder / "third.h5") as session:
        assert [run.completed for run in session.runs] == [True] * 3


@pytest.mark.thorough
def test_the_files_may_be_given_when_they_are_those_of_the_session_and_others_of_people_and_sample(
    failed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "rig"
    shutil.copytree(failed, folder)
    (folder / "other.toml").write_text('title = "by another person"\n')
    files = [folder / name for name in FILES]
    more = ("-o", folder / "whole.h5", "--about", folder / "other.toml")
    assert labrig("run", *files, "--resume", folder / "s.h5", *more) == 0
    with open_session(folder / "whole.h5") as session:
        assert session.about.title == "by another person"
        assert [run.completed for run in session.runs] == [True] * 3
    text = (folder / "protocol.toml").read_text()
    (folder / "protocol.toml").write_text(text.replace("zero_readings = 1", "zero_readings = 2"))
    capsys.readouterr()
    assert labrig("run", *files, "--resume", folder / "s.h5", "-o", folder / "other.h5") == 2
    assert "protocol.toml is not what this session was begun with" in capsys.readouterr().err
    assert not (folder / "other.h5").exists()


def test_a_complete_session_is_not_resumed(
    session: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert labrig("run", "--resume", session) == 2
    assert "nothing to resume" in capsys.readouterr().err


def test_a_run_of_which_no_reading_counts_is_measured_again(session: Path, tmp_path: Path) -> None:
    """Of a camera that turned black in the first run nothing could be had again."""
    path = tmp_path / "s.h5"
    shutil.copy(session, path)
    assert labrig("mark", path, "--run", "2", "--why", "a draught", "--who", "Ann") == 0
    assert labrig("run", "--resume", path) == 0
    with open_session(path) as old, open_session(tmp_path / "s-resumed.h5") as new:
        assert not any(row["valid"] for row in old.runs[1].readings)
        assert any(row["valid"] for row in new.runs[1].readings)
        first, again = (one.runs[0].readings["force_N"] for one in (old, new))
        np.testing.assert_array_equal(first, again)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run"], "needs rig.toml, protocol.toml and sheet.toml"),
        (["run", "rig.toml", "protocol.toml"], "needs rig.toml, protocol.toml and sheet.toml"),
        (["run", "rig.toml", "protocol.toml", "sheet.toml"], "needs -o"),
        (["run", "--resume", "no.h5"], "there is no such file"),
    ],
)
def test_what_is_missing_is_said(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert labrig(*arguments) == 2
    assert said in capsys.readouterr().err


@pytest.mark.thorough
def test_a_session_and_its_continuation_are_not_taken_together(
    failed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = tmp_path / "whole.h5"
    assert labrig("run", "--resume", failed / "s.h5", "-o", whole) == 0
    for command in ("fit", "diagnose"):
        assert labrig(command, whole, failed / "s.h5") == 2
        said = f"{whole}: holds the complete runs of {failed / 's.h5'}; give one of the two."
        assert said in capsys.readouterr().err


def test_the_continuation_of_a_continuation_names_both(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = make_rig(tmp_path / "rig", PROTOCOL, OVERLOADED_IN_THE_SECOND_RUN)
    first, second, third = (folder / f"{name}.h5" for name in ("first", "second", "third"))
    assert labrig("run", *(folder / f for f in FILES), "-o", first) == 5
    assert labrig("run", "--resume", first, "-o", second) == 5
    (folder / "world.toml").write_text("seed = 1\n")
    assert labrig("run", "--resume", second, "-o", third) == 0
    with open_session(first) as one, open_session(second) as two, open_session(third) as whole:
        assert whole.continues == {one.identifier: (0,), two.identifier: (0, 1)}
    assert labrig("fit", third, first) == 2
    assert f"{third}: holds the complete runs of {first}" in capsys.readouterr().err

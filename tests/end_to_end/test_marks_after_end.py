"""What is analysed after a reading was marked leaves it out, without being asked to."""

from __future__ import annotations

from pathlib import Path

import pytest

from labrig.session import load_measurements, open_session
from tests.end_to_end.small_rig import ONE_POSITION, labrig, make_rig, run_rig

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("data_unchecked")]


@pytest.mark.thorough
def test_a_fit_after_a_mark_analyses_again_and_leaves_the_reading_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = run_rig(make_rig(tmp_path / "rig", ONE_POSITION + 'mode = "paper"\n'))
    assert labrig("analyze", path) == 0
    before = sum(len(c.used()) for c in load_measurements(path).conditions)
    assert labrig("fit", path, "-o", path.with_suffix(".model.toml")) == 0
    with open_session(path) as session:
        reading = next(r["index"] for r in session.runs[0].readings if r["kind"] == "kept")
    marked = ("--run", 1, "--reading", reading + 1, "--why", "a bubble", "--who", "A")
    assert labrig("mark", path, *marked) == 0
    assert labrig("list", path.parent) == 0
    assert "analysis and fit out of date" in capsys.readouterr().out
    assert labrig("fit", path, "-o", tmp_path / "again.toml") == 0
    assert "were marked since it was analysed" in capsys.readouterr().err
    with open_session(path) as session:
        assert not session.outdated
    after = load_measurements(path)
    assert sum(len(c.used()) for c in after.conditions) == before - 1
    assert any(r.why == "a bubble" for c in after.conditions for r in c.readings)

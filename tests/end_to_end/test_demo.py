"""`labrig demo`, as `make demo` runs it."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.end_to_end.small_rig import labrig


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.skipif(sys.platform == "win32", reason="the simulated stage needs a pty")
def test_the_demo_prints_the_papers_tables_and_leaves_a_report(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert labrig("demo", tmp_path / "demo") == 0
    printed = capsys.readouterr().out
    for title in ("Table 4. Parameters", "Table 6. Root mean squared errors"):
        assert title in printed
    assert "The world's own record of the last voltage: 0 V" in printed
    assert "Where simulation and measurement disagree" in printed
    assert "Verdict: " in printed
    assert (tmp_path / "demo" / "model+.toml").exists()
    assert (tmp_path / "demo" / "diagnosis" / "index.html").exists()
    assert 'name = "nonuniform_eibm"' in (tmp_path / "demo" / "model+.toml").read_text()
    report = tmp_path / "demo" / "report"
    assert {p.stem for p in (report / "figures").glob("*.svg")} >= {
        f"figure-{number}" for number in range(5, 10)
    }
    page = (report / "index.html").read_text()
    assert all(f"Table {number}." in page for number in (3, 4, 6))
    assert "What the model is missing" in page
    assert labrig("demo", tmp_path / "demo") == 2

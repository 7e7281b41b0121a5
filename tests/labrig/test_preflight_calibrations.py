"""How old calibrations are, and those that nobody has made."""

from __future__ import annotations

from pathlib import Path

import pytest

from labrig.config.templates import write_templates
from labrig.experiment.plan import load_plan
from labrig.experiment.preflight import calibrations


def looked_at(folder: Path) -> dict[str, tuple[str, str]]:
    """Word and finding of each."""
    plan = load_plan(*(folder / f"{name}.toml" for name in ("rig", "protocol", "sheet")))
    return {check.name: (check.word, check.found) for check in calibrations(plan)}


def test_the_values_that_init_starts_a_rig_with_are_no_calibration(tmp_path: Path) -> None:
    write_templates(tmp_path, simulated=False)
    never = ("warning", "never made: labrig init's")
    assert looked_at(tmp_path) == {"load cell calibration": never, "camera calibration": never}


def test_a_simulated_rig_is_as_its_calibrations_say(tmp_path: Path) -> None:
    write_templates(tmp_path, simulated=True)
    assert {word for word, _ in looked_at(tmp_path).values()} == {"ok"}


@pytest.mark.parametrize(
    ("date", "word", "found"),
    [
        ("2020-01-01", "warning", " days old"),
        ("2999-01-01", "FAILED", "dated in the future"),
        ("yesterday", "FAILED", "dated 'yesterday'"),
    ],
)
def test_a_date_that_is_old_or_none_is_told(
    tmp_path: Path, date: str, word: str, found: str
) -> None:
    write_templates(tmp_path, simulated=False)
    optics = tmp_path / "optics.json"
    optics.write_text(optics.read_text().replace("1970-01-01", date))
    said = looked_at(tmp_path)["camera calibration"]
    assert said[0] == word
    assert found in said[1]

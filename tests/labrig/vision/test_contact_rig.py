"""The contact through the simulated rig: right where the stage is right, told where it is not."""

import re

import numpy as np
import pytest

from labrig.analysis import analyze
from labrig.session import load_measurements
from tests.end_to_end.small_rig import make_rig, run_rig

PROTOCOL = """
moisten = false

[pulse_train]
zero_readings = 2
readings_per_voltage = 1

[[places]]
configuration = "long"
positions_mm = [0, 15, 25]

[extras]
mode = "paper"
"""
EXACT = "[scatter]\neibm = 0.0\nstiffness = 0.0\nposition_mm = 0.0\n"
# the arc begins 1.8 mm further along than sheet.toml and stage have it
SHIFTED = EXACT + "[arc]\norigin_deg = 2.5783\n"


def analysed(folder, world):
    path = run_rig(make_rig(folder, PROTOCOL, world))
    made = analyze(path)
    assert load_measurements(path).conditions[0].contact == made.conditions[0].contact
    return made


def misses_m(made, shift_m):
    """How far each condition's contact is from where the rolls are, and its sigma."""
    contacts = [(c.contact, c.position_m + shift_m) for c in made.conditions]
    assert all(len(contact.rolls_m) == 2 for contact, _ in contacts)
    return np.array([(c.position_m - true, c.position_sigma_m) for c, true in contacts])


@pytest.mark.thorough
def test_a_stage_that_is_where_it_says_is_not_doubted(tmp_path):
    made = analysed(tmp_path, EXACT)
    miss, sigma = misses_m(made, 0.0).T
    assert (np.abs(miss) < np.maximum(3 * sigma, 60e-6)).all()
    assert not [text for text in made.warnings if "contact" in text or "arc" in text]


@pytest.mark.slow
def test_a_stage_that_is_elsewhere_is_reported_with_where_the_image_shows_it(tmp_path):
    made = analysed(tmp_path, SHIFTED)
    miss, sigma = misses_m(made, 1.8e-3).T
    assert (np.abs(miss) < np.maximum(3 * sigma, 60e-6)).all()
    told = [text for text in made.warnings if "shows the contact at" in text]
    assert [text.split(":")[0] for text in told] == ["long, 0 mm", "long, 15 mm", "long, 25 mm"]
    shown_mm = float(re.search(r"contact at ([\d.]+) ±", told[1])[1])
    assert shown_mm == pytest.approx(16.8, abs=0.1)
    assert any("all 3 runs" in text and "origin_deg" in text for text in made.warnings)

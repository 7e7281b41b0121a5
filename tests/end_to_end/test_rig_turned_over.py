"""A session with the rig turned over, from the protocol to the measurements."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from labrig.analysis.analyze import measure
from labrig.session import open_session
from model import Measurements
from tests.end_to_end.small_rig import ONE_POSITION, make_rig, run_rig

pytestmark = pytest.mark.slow

PROTOCOL = (
    ONE_POSITION
    + """random_order = false
no_touch_zero = false
reversed_approach = false
free_shapes = true
"""
)


def measured(folder: Path, protocol: str, load_N_per_m: float) -> Measurements:
    make_rig(folder, protocol, f"gravity_N_per_m = {load_N_per_m}\n")
    path = run_rig(folder)
    with open_session(path) as session:
        asked = [event for event in session.events if "Turn the whole rig over" in event.text]
        assert len(asked) == ("tilt_deg" in protocol)
        return measure(session, curves=False)


@pytest.mark.thorough
def test_weight_pulls_the_other_way_and_the_conditions_say_so(tmp_path: Path) -> None:
    over = measured(tmp_path / "over", PROTOCOL + "tilt_deg = 180\n", 0.01)
    other = measured(tmp_path / "other", PROTOCOL, -0.01)
    assert {c.tilt_rad for c in over.conditions} == {math.pi}
    assert {c.tilt_rad for c in other.conditions} == {0.0}
    for a, b in zip(over.conditions, other.conditions, strict=True):
        forces = [[r.force_N for r in c.readings] for c in (a, b)]
        np.testing.assert_allclose(*forces, rtol=1e-3, atol=1e-5)  # the same noise, too

"""Effects are fitted together: one that acts in time shapes what the other finds."""

from __future__ import annotations

import pytest

from benchmarks.hidden_effects.cases import Case, Hiding
from benchmarks.hidden_effects.sessions import hidden_session
from model.discrepancy import diagnose


@pytest.mark.slow
@pytest.mark.thorough
def test_a_lag_and_a_stiffness_that_depends_on_curvature_are_both_named():
    """The second is refined at the EIBM that the first leaves at the sampling point."""
    hidden = (Hiding("charging_lag"), Hiding("nonlinear_stiffness"))
    found = diagnose(hidden_session(Case(hidden, seed=905)).measurements)
    assert {one.name for one in found.effects} == {"charging_lag", "nonlinear_stiffness"}

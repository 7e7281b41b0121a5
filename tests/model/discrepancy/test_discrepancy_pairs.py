"""Effects are fitted together: one that acts in time shapes what the other finds."""

from __future__ import annotations

import pytest

from benchmarks.hidden_effects.cases import Case, Hiding
from benchmarks.hidden_effects.sessions import hidden_session
from model.discrepancy import Diagnosis, diagnose


def found_of(seed: int, *hidden: Hiding) -> Diagnosis:
    return diagnose(hidden_session(Case(hidden, seed=seed)).measurements)


@pytest.mark.slow
@pytest.mark.thorough
def test_a_lag_and_a_stiffness_that_depends_on_curvature_are_both_named():
    """The second is refined at the EIBM that the first leaves at the sampling point."""
    found = found_of(905, Hiding("charging_lag"), Hiding("nonlinear_stiffness"))
    assert {one.name for one in found.effects} == {"charging_lag", "nonlinear_stiffness"}


@pytest.mark.slow
@pytest.mark.thorough  # the benchmark of hidden effects counts pairs by the dozen
def test_two_that_explain_more_than_one_of_another_form_are_both_named():
    """A loop of the load cell, far from its form, explains more than either of them alone."""
    sticking = Hiding("roll_sticking", "from_the_middle", 0.117)
    found = found_of(1939532010, sticking, Hiding("load_cell_misalignment", "turned", 0.2))
    assert {one.name for one in found.effects} == {"roll_sticking", "load_cell_misalignment"}


@pytest.mark.slow
@pytest.mark.thorough
def test_a_second_change_in_time_that_has_many_names_is_told_by_them():
    """It is no rest of the first one's form, so that it is not unknown either."""
    creep = Hiding("viscoelastic_creep", "spread", 0.085)
    found = found_of(909033477, creep, Hiding("first_pulse_transient", "geometric", 0.00168))
    assert found.verdict == "indistinguishable"
    said = {n for one in found.effects for n in (one.name, *one.confusable_with)}
    assert {"viscoelastic_creep", "first_pulse_transient"} <= said

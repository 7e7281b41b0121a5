"""Contacts that a fit comes by on its way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.identification.likelihood.configuration.contact_search import beyond_end
from model.mechanics.equilibrium import SolverStatus, problems, solve
from model.mechanics.field import Field


def test_a_condition_that_leaves_the_sheet_is_solved_beyond_its_end_beside_any_others():
    """It alone might be solved with fewer nodes: it is bent less than the other one."""
    bends = [Field.constant(30.0, 0.05), Field.constant(-2.0, 0.05)]
    found = solve(replace(problems(bends, [0.2, 1.4], 0.045), turn_rad=None))
    assert found.status.tolist() == [SolverStatus.SOLVED, SolverStatus.SLIPPED]
    both = beyond_end(found)
    assert both.status.tolist() == [SolverStatus.SOLVED] * 2
    assert both.s_hat_m[1] > 0.05
    assert both.nu[0] == found.nu[0]
    assert np.all(np.isfinite(both.psi))

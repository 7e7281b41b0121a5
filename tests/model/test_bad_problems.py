"""A problem without meaning is refused in one sentence, before anything is solved."""

from __future__ import annotations

import numpy as np
import pytest

from model import ModelError
from model.mechanics.equilibrium import problems, solve
from model.mechanics.field import Field
from model.mechanics.tip_load import tip_load

R = 0.04
PLAIN = Field.constant(10.0, 0.05)
DIP = Field.linear(
    np.array([0.0, 0.0101, 0.0102, 0.0103, 0.05]), np.array([1, 1, -0.1, 1, 1]), 0.05
)


@pytest.mark.parametrize(
    ("fields", "text"),
    [
        ([], "at least one free curvature"),
        ([Field.constant(1.0, 0.0)], "free length must be positive, not 0 mm"),
        ([Field.constant(1.0, -0.01)], "free length must be positive, not -10 mm"),
        ([Field.constant(1.0, np.nan)], "free length must be positive, not nan mm"),
        ([PLAIN, Field.constant(1.0, 0.04)], "must end where its free length ends"),
        ([Field.constant(np.inf, 0.05)], "not finite everywhere"),
    ],
)
def test_a_free_curvature_without_meaning_is_refused(fields, text):
    with pytest.raises(ModelError, match=text):
        problems(fields, [0.1] * len(fields), R)


@pytest.mark.parametrize(
    ("softness", "text"),
    [
        (Field.constant(-1.0, 0.05), "stiffness must be positive"),
        (Field.constant(np.nan, 0.05), "stiffness must be positive"),
        (DIP, "stiffness must be positive"),
        (Field.constant(1.0, 0.04), "must end where its free length ends"),
    ],
)
def test_a_stiffness_without_meaning_is_refused(softness, text):
    with pytest.raises(ModelError, match=text):
        problems(PLAIN, 0.1, R, 0.0, softness)
    with pytest.raises(ModelError, match=text):
        tip_load(PLAIN, (0.0, 1.0), follows=False, softness=softness)


@pytest.mark.parametrize(
    ("force", "text"),
    [((np.nan, 1.0), "must be finite"), ((0.0, 1e6), "beyond any sheet: at most 200")],
)
def test_a_tip_load_without_meaning_is_refused(force, text):
    with pytest.raises(ModelError, match=text):
        tip_load(PLAIN, force, follows=True)


def test_a_tip_load_on_a_curvature_that_is_not_finite_is_refused():
    with pytest.raises(ModelError, match="not finite everywhere"):
        tip_load(Field.constant(np.nan, 0.05), (0.0, 1.0), follows=False)


def test_no_positions_are_no_equilibria():
    assert len(solve(problems(PLAIN, [], R)).nu) == 0

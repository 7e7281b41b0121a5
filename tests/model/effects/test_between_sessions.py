"""Effects that have a value of their own in each of several sessions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.effects import catalogue, effect
from model.effects.between_sessions import sessions_in
from model.effects.conformance import faults, plausible
from model.locations.examples import example_beam, example_points, example_weighed

EFFECTS = [name for name, one in catalogue().items() if sessions_in(k.name for k in one.parameters)]


def test_what_differs_from_session_to_session_has_an_effect_each():
    assert EFFECTS == [
        "session_curvature", "session_eibm", "session_stiffness", "session_position",
        "session_zero", "session_scale",
    ]  # fmt: skip


@pytest.mark.parametrize("name", EFFECTS)
def test_of_a_single_session_nothing_can_be_said(name: str):
    assert effect(name).for_sessions(1) is None
    assert effect("gravity").for_sessions(1) is effect("gravity")


@pytest.mark.slow
@pytest.mark.parametrize("name", EFFECTS)
def test_for_ten_sessions_there_is_a_value_for_each(name: str):
    ten = effect(name).for_sessions(10)
    assert ten is not None
    assert faults(ten) == []
    assert ten.parameters[-1].name.startswith("session_10")
    assert "session 10" in ten.parameters[-1].meaning
    assert all(one.estimated for one in ten.parameters[1:])
    assert len(ten.parameters) == len({one.name for one in ten.parameters})


def test_the_zero_of_each_session_is_its_own():
    numbers = np.array([1.0, 2.0, 3.0, 0.0, 7.0])
    weighed = replace(
        example_weighed(), force_N=np.zeros(5), session_number=numbers,
    )  # fmt: skip
    three = effect("session_zero").for_sessions(3)
    added = three.force(weighed, {"session_1_mN": 0.3, "session_2_mN": -0.6, "session_3_mN": 0.0})
    # of no session in particular: their mean
    np.testing.assert_allclose(added, [0.3e-3, -0.6e-3, 0.0, -0.1e-3, -0.1e-3], atol=1e-18)


def test_a_stiffness_told_from_the_first_session_on_leaves_the_mean_as_it_is():
    beam, contact = example_beam()
    changed = effect("session_stiffness").beam(beam, contact, {"session_2": 0.2})
    share = changed.stiffness / beam.stiffness
    np.testing.assert_allclose(share, np.where(beam.session_number == 1.0, 0.9, 1.1))
    np.testing.assert_allclose(changed.eibm * changed.stiffness[:, None],
                               beam.eibm * beam.stiffness[:, None])  # fmt: skip
    nowhere = replace(beam, session_number=0.0)
    same = effect("session_stiffness").beam(nowhere, contact, {"session_2": 0.2})
    np.testing.assert_array_equal(same.stiffness, beam.stiffness)


@pytest.mark.parametrize(
    ("name", "field"),
    [("session_eibm", "eibm"), ("session_curvature", "rest"), ("session_position", "shift_m")],
)
def test_the_beam_of_each_session_is_changed_in_its_own_way(name: str, field: str):
    beam, contact = example_beam()
    changed = effect(name).beam(beam, contact, plausible(effect(name)))
    apart = getattr(changed, field) - getattr(beam, field)
    up = beam.voltage_V > 0.0
    first, second = (apart[up & (beam.session_number == number)][0] for number in (1.0, 2.0))
    assert np.all(first != second)


def test_curves_of_another_session_have_another_scale():
    dx, dy = effect("session_scale").curve(example_points(), {"session_1": 0.02, "session_2": 0.0})
    np.testing.assert_allclose(dx[0], 0.02 * example_points().x_m[0])
    assert not np.any(dx[1])
    assert not np.any(dy[1])


def test_what_is_about_the_same_in_all_sessions_does_not_differ():
    zero, stiffness = effect("session_zero"), effect("session_stiffness")
    assert not zero.differs((3.0, 2.9))
    assert not zero.differs((-3.0, -2.4, -2.8))
    assert zero.differs((3.0, 0.1))
    assert zero.differs((0.1, -0.1))
    assert stiffness.differs((0.01,))  # a difference from the first session is one

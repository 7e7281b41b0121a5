"""Linear models: sampling with delays, reduction within its bound, refusals."""

import numpy as np
import pytest

from model.dynamics.linear.state_space import LinearSystem, balanced, discretised
from model.measurements import ModelError


def oscillator(frequency_hz=20.0, damping=0.05, direct=0.0):
    w = 2 * np.pi * frequency_hz
    return LinearSystem(
        A=np.array([[0.0, 1.0], [-(w**2), -2 * damping * w]]),
        B=np.array([[0.0], [w**2]]),
        C=np.array([[1.0, 0.0]]),
        D=np.array([[direct]]),
        inputs=("voltage_V",),
        outputs=("force_N",),
    )


def chain(stages=12):
    """A ladder of RC elements: many states, few of which matter."""
    A = -2 * np.eye(stages) + np.eye(stages, k=1) + np.eye(stages, k=-1)
    return LinearSystem(
        A=A,
        B=np.eye(stages)[:, :1],
        C=np.eye(stages)[-1:],
        D=np.zeros((1, 1)),
        inputs=("voltage_V",),
        outputs=("force_N",),
    )


@pytest.mark.parametrize("delay_s", [0.0, 0.003, 0.005, 0.0125])
def test_a_sampled_step_is_the_continuous_one_shifted_by_the_delay(delay_s):
    T = 0.005
    sampled = discretised(oscillator(), T, delay_s)
    found = sampled.simulate(np.ones((60, 1)))[:, 0]
    w, zeta = 2 * np.pi * 20.0, 0.05
    wd = w * np.sqrt(1 - zeta**2)
    t = np.clip(T * np.arange(60) - delay_s, 0.0, None)
    wave = np.cos(wd * t) + zeta * w / wd * np.sin(wd * t)
    np.testing.assert_allclose(found, 1 - np.exp(-zeta * w * t) * wave, atol=1e-12)


def test_a_direct_path_acts_after_the_delay_and_not_before():
    sampled = discretised(oscillator(direct=0.5), 0.005, 0.005)
    found = sampled.simulate(np.ones((2, 1)))[:, 0]
    assert found[0] == 0.0
    assert found[1] == pytest.approx(0.5)


def test_at_low_frequency_a_sampled_response_is_the_continuous_one_with_half_a_sample_of_delay():
    plain, sampled = oscillator(), discretised(oscillator(), 1e-4, 2e-4)
    f = np.array([1.0, 5.0, 30.0])
    wanted = plain.response(f)[:, 0, 0] * np.exp(-2j * np.pi * f * 2.5e-4)
    np.testing.assert_allclose(sampled.response(f)[:, 0, 0], wanted, rtol=1e-4)


def test_a_step_ends_at_the_static_gain():
    system = oscillator(damping=0.5, direct=0.25)
    assert system.step(np.linspace(0, 1, 500))[-1, 0] == pytest.approx(system.static_gain[0, 0])


@pytest.mark.parametrize("sampled", [False, True])
@pytest.mark.parametrize("states", [2, 4, 6])
def test_a_reduced_model_stays_within_its_bound(states, sampled):
    system = discretised(chain(), 0.1) if sampled else chain()
    reduced, bound = balanced(system, states)
    assert reduced.order == states
    assert reduced.is_stable
    f = np.geomspace(1e-4, 4.0, 200)
    error = np.abs(system.response(f) - reduced.response(f)).max()
    largest = np.abs(system.response(f)).max()
    assert 0.01 * bound < error <= bound * (1 + 1e-6) + 1e-12 * largest
    assert bound < largest


def test_more_states_than_there_are_change_nothing():
    reduced, bound = balanced(oscillator(), 9)
    assert (reduced.order, bound) == (2, 0.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"A": np.zeros((2, 3))}, "A of a linear model is 2 x 3"),
        ({"B": np.zeros((1, 1))}, "2 x 1 is needed"),
        ({"C": np.array([[np.nan, 0.0]])}, "C of a linear model has values that are not finite"),
        ({"sample_time_s": 0.0}, "not positive"),
    ],
)
def test_matrices_that_do_not_fit_are_refused_in_a_sentence(change, words):
    with pytest.raises(ModelError, match=words):
        LinearSystem(**{**vars(oscillator()), **change})


def test_an_unstable_model_is_not_reduced():
    with pytest.raises(ModelError, match="only a stable linear model"):
        balanced(oscillator(damping=-0.1), 1)


def test_an_output_that_is_not_there_is_named():
    with pytest.raises(ModelError, match="no output tip_m, only force_N"):
        oscillator().output("tip_m")

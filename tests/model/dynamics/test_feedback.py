"""Controllers of the long sheet's force: gains, margins, limits of the voltage."""

from dataclasses import replace

import numpy as np
import pytest

from model.dynamics.linear.feedback import ForceController, LqgWeights, lqg, pi
from model.dynamics.linear.state_space import LinearSystem, balanced, discretised
from model.measurements import ModelError
from tests.cases import few
from tests.model.dynamics.sheets import beam, model_of

LIMIT_V = 2.0
STEP_N = 1e-3


@pytest.fixture(scope="module")
def long_sheet():
    return model_of(beam(), 0.0).output("force_N")


def loop_of(sheet, method, rate_hz=200.0, delay_s=3e-3):
    plant = discretised(sheet, 1 / rate_hz, delay_s)
    if method == "pi":
        return plant, pi(plant)
    return plant, lqg(plant, discretised(balanced(sheet, 8)[0], 1 / rate_hz, delay_s))


def bandwidth_hz(plant, controller):
    f = np.geomspace(0.01, 0.5 / plant.sample_time_s, 600)
    gain = np.abs(controller.closed_loop(plant).output("force_N").response(f)[:, 0, 0])
    return f[np.flatnonzero(gain < np.sqrt(0.5))[0]]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("rate_hz", "delay_s", "wanted_hz"),
    few([(200.0, 3e-3, 5.6), (1000.0, 5e-4, 4.0), (25.0, 0.04, 2.4)]),
)
def test_a_pi_loop_is_as_fast_as_the_delay_and_the_light_mode_allow(
    long_sheet, rate_hz, delay_s, wanted_hz
):
    """Bandwidths that a prototype found at p = 0 with the same rule."""
    plant, controller = loop_of(long_sheet, "pi", rate_hz, delay_s)
    assert controller.sensitivity_peak(plant) == pytest.approx(1.6, abs=1e-3)
    assert bandwidth_hz(plant, controller) == pytest.approx(wanted_hz, rel=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("method", few(["pi", "lqg"]))
def test_a_loop_is_stable_within_its_margin_and_reaches_the_reference(long_sheet, method):
    plant, controller = loop_of(long_sheet, method)
    closed = controller.closed_loop(plant)
    assert closed.is_stable
    assert closed.output("force_N").static_gain[0, 0] == pytest.approx(1.0, rel=1e-6)
    assert controller.sensitivity_peak(plant) <= 1.6 * (1 + 1e-9)


@pytest.mark.slow
def test_with_a_higher_gain_the_margin_is_gone(long_sheet):
    plant, controller = loop_of(long_sheet, "pi")
    more = replace(controller.law, B=1.1 * controller.law.B, D=1.1 * controller.law.D)
    stronger = ForceController(law=more, anti_windup=controller.anti_windup)
    assert stronger.sensitivity_peak(plant) > 1.65


def settled_s(force_N, sample_time_s):
    off = np.flatnonzero(np.abs(force_N - STEP_N) > 0.02 * STEP_N)
    return (off[-1] + 1) * sample_time_s


@pytest.mark.slow
@pytest.mark.parametrize(("method", "within_s"), [("pi", 0.5), ("lqg", 0.3)])
def test_a_step_of_1_mN_settles_within_the_limits_of_the_voltage(long_sheet, method, within_s):
    plant, controller = loop_of(long_sheet, method)
    force_N, voltage_V = controller.follow(plant, np.full(300, STEP_N), LIMIT_V)
    assert np.abs(voltage_V).max() == LIMIT_V
    assert settled_s(force_N, plant.sample_time_s) <= within_s
    assert force_N.max() < 1.15 * STEP_N


@pytest.mark.slow
@pytest.mark.parametrize("method", ["pi", "lqg"])
def test_a_voltage_at_its_limit_for_long_winds_nothing_up(long_sheet, method):
    """Beyond reach for 5 s: back within reach the voltage leaves the limit at once."""
    plant, controller = loop_of(long_sheet, method)
    reference = np.concatenate([np.full(1000, 20e-3), np.zeros(200)])
    _, voltage_V = controller.follow(plant, reference, LIMIT_V)
    assert voltage_V[999] == LIMIT_V
    assert voltage_V[1000:1003].min() < LIMIT_V
    naive = replace(controller, anti_windup=np.zeros_like(controller.anti_windup))
    if method == "pi":
        _, wound_V = naive.follow(plant, reference, LIMIT_V)
        assert wound_V[1000:1100].min() == LIMIT_V


@pytest.mark.slow
def test_a_sheet_that_pushes_the_other_way_gets_the_same_loop_with_the_other_sign(long_sheet):
    turned = replace(long_sheet, C=-long_sheet.C)
    _, controller = loop_of(turned, "pi")
    plant, wanted = loop_of(long_sheet, "pi")
    np.testing.assert_allclose(controller.law.D, -wanted.law.D)
    plant, controller = loop_of(turned, "lqg")
    assert controller.closed_loop(plant).is_stable


@pytest.mark.slow
def test_a_noisier_force_makes_lqg_gentler(long_sheet):
    plant = discretised(long_sheet, 0.005, 0.003)
    design = discretised(balanced(long_sheet, 8)[0], 0.005, 0.003)
    calm, noisy = (
        lqg(plant, design, LqgWeights(force_noise_N=noise_N)) for noise_N in (5e-5, 5e-4)
    )
    assert noisy.integral_gain < 0.5 * calm.integral_gain


@pytest.mark.slow
def test_a_controller_for_another_rate_is_refused(long_sheet):
    _, controller = loop_of(long_sheet, "pi")
    with pytest.raises(ModelError, match="the controller runs at 200 Hz, its model at 100 Hz"):
        controller.closed_loop(discretised(long_sheet, 0.01, 0.003))


def one_sample_late(direct):
    return LinearSystem(
        A=np.zeros((1, 1)), B=np.ones((1, 1)), C=np.ones((1, 1)), D=np.full((1, 1), direct),
        inputs=("voltage_V",), outputs=("force_N",), sample_time_s=0.01,
    )  # fmt: skip


def test_a_pure_delay_is_controlled_within_the_margin():
    plant = one_sample_late(0.0)
    controller = pi(plant)
    assert controller.sensitivity_peak(plant) == pytest.approx(1.6, rel=1e-3)
    assert controller.closed_loop(plant).is_stable


def test_a_plant_that_answers_within_the_sample_is_refused():
    with pytest.raises(ModelError, match="answers within the sample"):
        pi(one_sample_late(1.0))

"""How smooth a curve is, as the image says: mean and covariance over many priors."""

import numpy as np
import pytest

from labrig.vision import neutral_curve
from labrig.vision.curve.shape import make_basis
from labrig.vision.curve.smoothness import PRIOR_TURNS_RAD, averaged, covariance, smooth_priors


@pytest.fixture(scope="module")
def basis():
    return make_basis(440.0, 440.0, 21)


def seen(basis, truth, noise, rng):
    """The equations of data that show the curvature (nodes,) itself, each node with this noise."""
    rows = np.zeros((len(basis.s), basis.size))
    rows[:, 2:] = basis.curvature
    normal = rows.T @ rows / noise**2 + np.diag([1.0, 1.0] + [0.0] * (basis.size - 2))
    return normal, rows.T @ (truth + rng.normal(0, noise, len(truth))) / noise**2


def smooth_of(basis, normal, pull):
    data = (normal, pull, basis.priors, basis.log_weight)
    rows, among = basis.curvature, covariance(*data)[2:, 2:]
    return rows @ averaged(*data)[2:], np.sqrt(((rows @ among) * rows).sum(axis=1))


def test_the_mean_of_all_answers_is_weighed_by_how_likely_their_priors_make_the_data(basis):
    rng = np.random.default_rng(1)
    normal, pull = seen(basis, 0.005 * np.sin(basis.s / 60), 0.01, rng)
    answers, evidence = [], []
    for prior in basis.priors:
        full = normal.copy()
        full[2:, 2:] += prior
        answers.append((np.linalg.solve(full, pull), np.linalg.inv(full)))
        determinants = np.linalg.slogdet(prior)[1] - np.linalg.slogdet(full)[1]
        evidence.append(0.5 * (pull @ answers[-1][0] + determinants))
    odds = np.exp(np.array(evidence) - max(evidence))
    odds /= odds.sum()
    wanted = sum(w * p for w, (p, _) in zip(odds, answers, strict=True))
    spread = sum(
        w * (c + np.outer(p - wanted, p - wanted)) for w, (p, c) in zip(odds, answers, strict=True)
    )
    data = (normal, pull, basis.priors, basis.log_weight)
    assert averaged(*data) == pytest.approx(wanted, abs=1e-9)
    assert covariance(*data) == pytest.approx(spread, abs=1e-3 * spread.max())
    assert odds.max() < 0.9  # else one prior alone would do


@pytest.mark.parametrize("kind", [0, len(PRIOR_TURNS_RAD)])
@pytest.mark.parametrize("strength", [1, 3, 5])
def test_a_prior_of_either_kind_lets_a_sheet_turn_by_about_what_its_strength_says(
    basis, kind, strength
):
    wave = np.cos(np.pi * basis.s / basis.free_px) / basis.free_px
    c = np.linalg.lstsq(basis.curvature, wave, rcond=None)[0]
    likely_rad = 1 / np.sqrt(c @ basis.priors[kind + strength] @ c)
    assert 0.2 < likely_rad / PRIOR_TURNS_RAD[strength] < 3


def test_curvature_that_falls_off_at_the_root_is_found_better_than_by_one_that_wanders(basis):
    truth = 0.01 * np.exp(-basis.s / 90)
    misses, inside = [], []
    for seed in range(20):
        normal, pull = seen(basis, truth, 0.002, np.random.default_rng(seed))
        found, sigma = smooth_of(basis, normal, pull)
        half = len(basis.priors) // 2
        mean = averaged(normal, pull, basis.priors[:half], basis.log_weight[:half])
        alone = basis.curvature @ mean[2:]
        misses.append([np.sum((found - truth) ** 2), np.sum((alone - truth) ** 2)])
        inside.append(np.mean(np.abs(found - truth) < 1.96 * sigma))
    with_both, with_one = np.mean(misses, axis=0)
    assert with_both < 0.6 * with_one
    assert 0.85 < np.mean(inside) <= 1.0


def test_a_jump_is_not_smoothed_away(basis):
    truth = np.where(basis.s < 200, 0.0, 0.02)
    normal, pull = seen(basis, truth, 0.002, np.random.default_rng(3))
    found, _ = smooth_of(basis, normal, pull)
    away = np.abs(basis.s - 200) > 50
    assert np.sqrt(np.mean((found - truth)[away] ** 2)) < 0.0006


def test_priors_do_not_depend_on_the_unit_of_length(basis):
    other = 1000.0  # of the new unit in one of the old: curvatures are as much larger
    wander, sway = basis.penalty, np.eye(len(basis.penalty))
    priors = smooth_priors(wander * other, sway * other**3, basis.free_px / other)
    assert priors * other**2 == pytest.approx(smooth_priors(wander, sway, basis.free_px), rel=1e-9)


@pytest.mark.slow
def test_curvature_and_its_band_on_plain_sheets(scenes, known):
    misses, inside = [], []
    for seed in (3_000_001, 3_000_005, 3_000_007, 3_000_021):  # that bend most at the root
        scene = scenes.make_scene(scenes.Recipe(seed=seed, physical=True, bright=seed % 2 == 0))
        curve = neutral_curve(scene.image, *known(scene))
        k = np.interp(curve.s_m * 1000, scene.s_mm, scene.k_per_m)
        miss = curve.curvature_per_m - k
        misses.append(np.sqrt(np.mean(miss**2)))
        inside.append(np.mean(np.abs(miss) < 1.96 * curve.curvature_sigma_per_m))
        assert 0.003 < curve.curvature_resolution_m < 0.008
    assert np.mean(misses) < 1.2
    assert np.mean(inside) > 0.85

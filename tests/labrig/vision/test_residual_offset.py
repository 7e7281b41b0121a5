"""Where the image lies beside the curve, and no model of it says why, the band must hold that."""

import json

import numpy as np
import pytest

from benchmarks import vision_scenes
from benchmarks.vision_extraction import signed_errors_px
from labrig.vision import Optics, StripGeometry, neutral_curve
from labrig.vision.fit.curve_fit import around

PX_PER_MM, FREE_MM, THICK_PX = 9.0, 100.0, 15.0


@pytest.fixture(scope="module")
def knotted():
    """A straight frayed strip (300, 1050), 15 pixels thick and twice that in one place.

    With its upper and lower edge by columns, in pixels.
    """
    rng = np.random.default_rng(7)
    rows, columns = np.mgrid[0:300, 0:1050]
    knots = np.arange(0, 1051, 12)
    fray = [np.interp(columns[0], knots, rng.normal(0, 0.8, len(knots))) for _ in range(2)]
    knot = 16 * np.exp(-(((columns[0] - 400) / 70.0) ** 4))
    upper = 150 - THICK_PX / 2 - fray[0]
    lower = 150 + THICK_PX / 2 + fray[1] + knot
    inside = (rows > upper) & (rows < lower) & (columns > 60) & (columns < 60 + FREE_MM * PX_PER_MM)
    grey = np.where(inside, 180 + rng.normal(0, 12, rows.shape), 12) + rng.normal(0, 2, rows.shape)
    return np.clip(grey, 0, 255).astype(np.uint8), upper, lower


@pytest.mark.slow
def test_the_band_holds_the_middle_of_a_strip_where_a_knot_makes_one_side_thicker(knotted):
    image, upper, lower = knotted
    optics = {"px_per_mm": PX_PER_MM, "clamp_px": [60.0, 150.0]}
    strip = StripGeometry(
        free_length_m=FREE_MM / 1000, elongation_m=0.0, thickness_m=THICK_PX / PX_PER_MM / 1000
    )
    curve = neutral_curve(image, Optics.from_json(json.dumps(optics)), strip)
    assert curve.ok, curve.why
    u, v = curve.points_px.T
    knot = (u > 350) & (u < 450)
    middle = np.interp(u, np.arange(len(upper)), (upper + lower) / 2)
    assert np.abs(middle - v)[knot].max() < 2.0  # the knot's middle is 8 beside the strip's
    sigma_px = curve.sigma_m * PX_PER_MM * 1000
    assert (np.abs(middle - v) < 1.96 * sigma_px)[knot].mean() > 0.9
    elsewhere = (u > 600) & (u < 900)
    assert np.abs(middle - v)[elsewhere].max() < 1.0
    assert sigma_px[elsewhere].max() < 0.6 * sigma_px[knot].max()


@pytest.fixture(scope="module")
def stepped():
    """A sheet straight up to its middle, where its curvature jumps: no smooth one follows it."""
    s = np.linspace(0, 50, 4001)
    k = np.where(s < 25, 0.0, 0.08)
    phi = np.concatenate([[0], np.cumsum((k[1:] + k[:-1]) / 2 * s[1])])
    x, y = (
        np.concatenate([[0], np.cumsum((f(phi[1:]) + f(phi[:-1])) / 2 * s[1])])
        for f in (np.cos, np.sin)
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            vision_scenes,
            "truth_curve",
            lambda recipe, rng: (s, np.stack([x, y], axis=1), k * 1000, phi),
        )
        return [
            vision_scenes.make_scene(vision_scenes.Recipe(seed=seed, snr=40)) for seed in range(4)
        ]


@pytest.mark.slow
def test_the_credible_band_holds_the_sheet_beside_a_jump_of_its_curvature(stepped, known):
    """Without what the image says there it holds a quarter."""
    held = []
    for scene in stepped:
        curve = neutral_curve(scene.image, *known(scene))
        assert curve.ok, curve.why
        near = np.abs(curve.s_m - 0.025) < 4.5e-3
        miss_px = signed_errors_px(curve, scene)[near]
        held.append(np.mean(np.abs(miss_px) < 1.96 * curve.sigma_m[near] * 8900))
    assert np.mean(held) > 0.75


@pytest.mark.parametrize("n", [3, 5, 9])
def test_sums_around_each_cell_are_as_many_as_cells(n):
    np.testing.assert_array_equal(around(np.ones(n), 1), [2.0, *(n - 2) * [3.0], 2.0])
    assert len(around(np.ones(n), 4)) == n

"""What shows beside the sheet's edge, chosen in optics.json or on the command line."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.vision import neutral_curve
from tests.cases import few


@pytest.fixture(scope="module")
def silhouette(scenes, tmp_path_factory):
    folder = tmp_path_factory.mktemp("look")
    scene = scenes.make_scene(scenes.Recipe(seed=902, physical=True, face=1.0, bright=False))
    scenes.save(scene, folder, "dark")
    return folder / "dark.png"


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize("look", ["silhouette", pytest.param("auto", marks=pytest.mark.thorough)])
def test_the_look_is_an_option(silhouette, look, capsys):
    assert run(["curves", str(silhouette), "--look", look, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["ok"]
    assert any("side face" in text for text in told["warnings"])


@pytest.mark.slow
def test_another_look_is_refused_with_what_there_is(silhouette, capsys):
    assert run(["curves", str(silhouette), "--look", "glow"]) == 2
    assert "silhouette" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("radius_px", few([2.0, 2.6]))
def test_a_lens_far_out_of_focus_is_not_taken_for_a_side_face(scenes, known, radius_px):
    """It draws discs, not bells: the sheet looks wider, to both its sides."""
    scene = scenes.make_scene(scenes.Recipe(seed=3, physical=True, blur_px=0.6, snr=4000))
    v, u = np.mgrid[-4:5, -4:5]
    disc = np.clip(radius_px - np.hypot(u, v) + 0.5, 0, 1)
    image = cv2.filter2D(scene.image.astype(float), -1, disc / disc.sum())
    image += np.random.default_rng(1).normal(0, 3, image.shape)
    curve = neutral_curve(np.clip(image, 0, 255).astype(np.uint8), *known(scene))
    assert curve.ok, curve.why
    assert curve.side_face_share == 0
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.08


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "face"),
    [
        (960_061, 0.85),
        *(pytest.param(s, 0.85, marks=pytest.mark.thorough) for s in (960_029, 3_100_054)),
    ],
)
def test_a_face_that_is_not_separated_from_the_edge_widens_the_credible_band(
    scenes, known, seed, face
):
    """A thicker sheet, blur in much noise, something in one place: each explains as much."""
    scene = scenes.make_scene(replace(scenes.mixed(seed), face=face))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok
    assert curve.side_face_share == 0
    miss_px = scenes.rmse_px(curve.points_px, scene.truth_px)
    assert miss_px > 0.3
    assert 1.96 * curve.sigma_m.mean() * scene.recipe.px_per_mm * 1000 > miss_px
    assert any("wider than it is thick" in text for text in curve.warnings)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("seed", "face"), [(960_024, 0.2), pytest.param(960_057, 0.7, marks=pytest.mark.thorough)]
)
def test_a_faint_face_is_found_in_an_image_of_little_noise(scenes, known, seed, face):
    """Taken for blur, it pulled the curve by 0.18 and 0.48 pixels."""
    scene = scenes.make_scene(replace(scenes.mixed(seed), face=face))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok
    assert curve.side_face_share > 0
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.06


@pytest.mark.thorough
def test_a_face_beside_an_elongation_of_unknown_width_is_found(scenes, known):
    """The elongation was taken for a thicker one, and its middle missed by 1.07 pixels."""
    scene = scenes.make_scene(replace(scenes.mixed(2_300_033), face=1.0))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.2


@pytest.mark.thorough
def test_a_free_sheet_too_wide_to_be_used_tells_of_its_face(scenes, known):
    """The elongation is as wide with a face as without; left to it, the curve missed by 1.48 px."""
    scene = scenes.make_scene(replace(scenes.mixed(3_100_014), face=1.0))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok
    assert curve.side_face_share > 0.9
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.1


@pytest.mark.thorough
@pytest.mark.slow
def test_what_looks_much_wider_than_the_sheet_gives_no_curve(scenes, known):
    """A silhouette's face and a wire beside it: nothing tells which part is the edge."""
    scene = scenes.make_scene(replace(scenes.mixed(2_300_024), face=1.0))
    curve = neutral_curve(scene.image, *known(scene))
    assert not curve.ok
    assert "wider than the sheet" in curve.why


@pytest.mark.thorough
@pytest.mark.slow
def test_the_mean_image_of_a_swinging_sheet_is_not_taken_for_a_side_face(scenes, known):
    """It is blurred more and more towards the tip, on both sides alike."""
    recipe = scenes.Recipe(seed=60100000, physical=True, snr=80, bright=True, swing_px=0.75)
    scene = scenes.make_scene(recipe)
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert curve.side_face_share == 0
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.05

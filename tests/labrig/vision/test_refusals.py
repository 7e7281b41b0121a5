from dataclasses import replace

import numpy as np
import pytest

from labrig.errors import BadInputError
from labrig.extractors.examples import drawn_arc
from labrig.vision import StripGeometry, neutral_curve
from tests.cases import few
from tests.labrig.vision.drawn_strips import BENT_UP, STRIP


def refused(image, optics, strip, said):
    curve = neutral_curve(image, optics, strip)
    assert not curve.ok
    assert said in curve.why
    assert curve.why.endswith(".")
    assert curve.s_m.size == 0
    assert curve.points_px.shape == (0, 2)


@pytest.mark.slow
def test_a_refusal_names_the_step_that_failed(plain, known):
    optics, strip = known(plain)
    refused(np.zeros_like(plain.image), optics, strip, "check of the image failed: the image is")
    noise = np.random.default_rng(4).normal(90, 6, plain.image.shape).astype(np.uint8)
    refused(noise, optics, strip, "search failed: no")
    refused(plain.image, optics, replace(strip, free_length_m=0.043), "check of the end failed: ")


def test_an_elongation_that_turns_by_more_than_one_can_is_told_as_one():
    """The clamp and the length were blamed."""
    rolled = drawn_arc("an arc of 69 degrees", 40.0, BENT_UP.optics)
    strip = StripGeometry(
        free_length_m=0.003, elongation_m=STRIP.free_length_m - 0.003,
        thickness_m=STRIP.thickness_m,
    )  # fmt: skip
    refused(rolled.image, rolled.optics, strip, "the elongation would turn by")
    assert neutral_curve(rolled.image, rolled.optics, STRIP).ok


def test_a_wrong_length_is_not_put_down_to_the_elongation():
    too_long = StripGeometry(free_length_m=0.012, elongation_m=0.033, thickness_m=STRIP.thickness_m)
    curve = neutral_curve(BENT_UP.image, BENT_UP.optics, too_long)
    assert not curve.ok
    assert "elongation" not in curve.why


def test_a_black_image(plain, known):
    refused(np.zeros_like(plain.image), *known(plain), "uniform")


def test_a_saturated_image(plain, known):
    image = np.full_like(plain.image, 255)
    image[:40, :40] = 0
    refused(image, *known(plain), "saturated")


def test_a_camera_that_leaves_most_of_sixteen_bits_empty(plain, known):
    optics, strip = known(plain, bits=16)
    dim = (300 + 1.5 * plain.image.astype(float)).astype(np.uint16)  # 1 % of full scale is 655
    assert neutral_curve(dim, optics, strip).ok
    refused(np.full_like(dim, 300), optics, strip, "uniform")


def test_not_an_image(plain, known):
    refused([[1, 2]], *known(plain), "not an image")
    refused(np.zeros((480, 640), complex), *known(plain), "save it with 8 or 16 bits")
    refused(np.full((480, 640), np.nan), *known(plain), "finite")


def test_an_image_of_another_size_than_the_calibration(plain, known):
    refused(plain.image[:400], *known(plain), "calibrated for 640 x 480")


def test_colour_is_used_with_a_warning(plain, known):
    colour = np.stack([plain.image, plain.image, np.minimum(plain.image, 250) + 5], axis=2)
    curve = neutral_curve(colour.astype(np.uint8), *known(plain))
    assert curve.ok
    assert any("colour" in w for w in curve.warnings)


def test_three_equal_channels_are_grey(plain, known):
    curve = neutral_curve(np.repeat(plain.image[:, :, None], 3, axis=2), *known(plain))
    assert curve.ok
    assert not curve.warnings


@pytest.mark.slow
def test_a_clamp_that_is_somewhere_else(plain, known):
    optics, strip = known(plain)
    u, v = optics.clamp_px
    curve = neutral_curve(plain.image, optics.model_copy(update={"clamp_px": (u, v - 60)}), strip)
    assert not curve.ok


@pytest.mark.slow
def test_a_clamp_outside_the_image(plain, known):
    optics, strip = known(plain)
    curve = neutral_curve(plain.image, optics.model_copy(update={"clamp_px": (-90, -90)}), strip)
    assert not curve.ok


@pytest.mark.slow
def test_the_wrong_polarity(plain, known):
    optics, strip = known(plain, polarity="dark")
    assert not neutral_curve(plain.image, optics, strip).ok


@pytest.mark.slow
@pytest.mark.parametrize("factor", few([0.85, 1.15]))
def test_another_cameras_scale(plain, known, factor):
    optics, strip = known(plain)
    other = optics.model_copy(update={"px_per_mm": optics.px_per_mm * factor})
    refused(plain.image, other, strip, "px_per_mm")


@pytest.mark.slow
@pytest.mark.parametrize("factor", few([0.85, 1.15]))
def test_a_sheet_of_another_length(plain, known, factor):
    optics, _ = known(plain)
    refused(
        plain.image,
        optics,
        StripGeometry(free_length_m=0.05 * factor, thickness_m=0.21e-3),
        "length",
    )


@pytest.mark.slow
def test_a_sheet_that_leaves_the_image(scenes, known):
    scene = scenes.make_scene(scenes.Recipe(seed=3, physical=True))
    edge = int(scene.truth_px[:, 0].max()) - 60
    optics, strip = known(scene, image_size=[edge, 480])
    assert not neutral_curve(np.ascontiguousarray(scene.image[:, :edge]), optics, strip).ok


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", few([0, 1, 2, *(pytest.param(s, marks=pytest.mark.thorough) for s in (3, 4, 5))])
)
def test_clutter_without_a_sheet(scenes, known, seed):
    scene = scenes.make_scene(scenes.Recipe(seed=seed, sheet=False, clutter=3 * seed, spots=2))
    assert not neutral_curve(scene.image, *known(scene)).ok


@pytest.mark.slow
def test_two_sheets_at_one_clamp(scenes, known):
    one = scenes.make_scene(scenes.Recipe(seed=5, place=(100.0, 240.0), turn_rad=0.8, clamp=False))
    other = scenes.make_scene(
        scenes.Recipe(seed=5, place=(100.0, 240.0), turn_rad=-0.8, clamp=False)
    )
    shift = np.round(one.truth_px[0] - other.truth_px[0]).astype(int)
    moved = np.roll(other.image, (shift[1], shift[0]), axis=(0, 1))
    both = np.maximum(one.image, moved)
    refused(both, *known(one), "two sheets")


@pytest.mark.thorough
@pytest.mark.slow
def test_a_weak_reflection_beside_the_sheet_is_no_second_one(scenes, known):
    scene = scenes.make_scene(scenes.Recipe(seed=5, place=(100.0, 240.0), turn_rad=0.8))
    ground = np.median(scene.image)
    away = np.roll(scene.image.astype(float) - ground, 10, axis=0)
    for share, taken in ((0.4, True), (0.9, False)):
        image = np.clip(scene.image + share * away, 0, 255).astype(np.uint8)
        curve = neutral_curve(image, *known(scene))
        assert curve.ok == taken
        if taken:
            assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.1
            assert any("reflection" in w for w in curve.warnings)
        else:
            assert "two sheets" in curve.why


def test_geometry_that_cannot_be():
    for free_m, elongation_m, thickness_m in (
        (0.0, 0.0, 0.2e-3),
        (0.05, -0.01, 0.2e-3),
        (0.05, 0.0, 0.0),
        (0.05, 0.0, 0.06),
    ):
        with pytest.raises(BadInputError, match="mm"):
            StripGeometry(free_length_m=free_m, elongation_m=elongation_m, thickness_m=thickness_m)


@pytest.mark.slow
@pytest.mark.parametrize(
    "factor",
    few(
        [
            0.95,
            1.05,
            *(pytest.param(f, marks=pytest.mark.thorough) for f in (0.85, 0.92, 1.08, 1.15)),
        ]
    ),
)
@pytest.mark.parametrize(
    "seed",
    few(
        [810_000, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in (810_018, 810_023))]
    ),
)
def test_a_wrong_scale_is_seen_from_the_sheets_end(scenes, known, factor, seed):
    """Scenes whose true end lies far beyond the stated one, under a roll, or in much noise."""
    scene = scenes.make_scene(scenes.mixed(seed))
    optics, strip = known(scene)
    assert neutral_curve(scene.image, optics, strip).ok
    other = optics.model_copy(update={"px_per_mm": optics.px_per_mm * factor})
    assert not neutral_curve(scene.image, other, strip).ok


@pytest.mark.slow
@pytest.mark.parametrize("seed", few([700_047, 700_052]))
def test_a_line_that_happens_to_leave_the_clamp_is_no_sheet(scenes, known, seed):
    """It goes on for too long, up to the image's border."""
    recipe = replace(scenes.mixed(seed), sheet=False, rolls=False, clutter=3 + seed % 17)
    scene = scenes.make_scene(recipe)
    curve = neutral_curve(scene.image, *known(scene))
    assert not curve.ok
    reasons = ("ends at least", "leaves the image", "beside the clamp")
    assert any(reason in curve.why for reason in reasons)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_line_that_continues_beyond_what_crosses_its_stated_end_is_no_sheet(scenes, known):
    """The brighter line that crosses it there hides that it is 90 pixels too long."""
    recipe = replace(scenes.mixed(12_400_120), sheet=False, rolls=False, clutter=17)
    scene = scenes.make_scene(recipe)
    curve = neutral_curve(scene.image, *known(scene))
    assert not curve.ok
    assert "ends at least" in curve.why


@pytest.mark.slow
@pytest.mark.thorough
def test_sheetless_and_cluttered_images_give_no_curve(scenes, known):
    for seed in range(2000, 2030):
        recipe = replace(scenes.mixed(seed), sheet=False, rolls=False, clutter=(seed % 3) * 8)
        scene = scenes.make_scene(recipe)
        assert not neutral_curve(scene.image, *known(scene)).ok, seed


@pytest.mark.slow
@pytest.mark.parametrize(("share", "along_px"), few([(0.23, 4), (0.35, 4), (0.3, -4)]))
def test_a_reflection_that_touches_the_sheet_is_in_the_credible_band(
    scenes, known, share, along_px
):
    """Its light on one side pulls the curve by a tenth of a pixel, five times what noise does."""
    recipe = scenes.Recipe(seed=5, place=(100.0, 240.0), turn_rad=0.8)
    scene = scenes.make_scene(recipe)
    without = neutral_curve(scene.image, *known(scene))
    light = scenes.make_scene(replace(recipe, snr=1e6)).image.astype(float)
    second = np.roll(np.clip(light - np.median(light), 0, None), along_px, axis=0)
    image = np.clip(scene.image + share * second, 0, 255).astype(np.uint8)
    curve = neutral_curve(image, *known(scene))
    assert not any("touches" in w for w in without.warnings)
    assert curve.ok, curve.why
    assert any("touches the sheet" in w for w in curve.warnings)
    miss_px = scenes.rmse_px(curve.points_px, scene.truth_px)
    assert miss_px > 0.05
    assert 1.96 * np.sqrt(np.mean(curve.sigma_m**2)) * recipe.px_per_mm * 1000 > miss_px
    again = neutral_curve(image, *known(scene), start=curve)
    assert any("touches the sheet" in w for w in again.warnings)
    assert again.sigma_m == pytest.approx(curve.sigma_m, rel=0.2)

"""What is taken for a part of the sheet, and is none: told by its grey, and by where it leads."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.vision import neutral_curve
from tests.cases import few


@pytest.mark.thorough
@pytest.mark.slow
def test_a_wire_is_not_followed_where_the_sheet_disappears_before_something_as_bright(
    scenes, known
):
    """A disc of the sheet's grey hides 12 mm of it, and a wire that passes there is seen."""
    seed = 1_800_314
    scene = scenes.make_scene(replace(scenes.mixed(seed), clutter=2 + seed % 10))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.2
    assert curve.covered < 0.8


def test_a_sheet_that_is_seen_before_another_ground_is_used_there(scenes, known):
    scene = scenes.make_scene(scenes.Recipe(seed=3, physical=True))
    u, v = scene.truth_px[len(scene.truth_px) // 2]
    image = scene.image.astype(float)
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]]
    free = np.clip(1 - (image - 50) / 120, 0, 1)  # share of a pixel that the sheet leaves
    image += 70 * free * (np.hypot(columns - u, rows - v) < 70)
    curve = neutral_curve(np.clip(image, 0, 255).astype(np.uint8), *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.1
    middle = slice(2 * len(curve.seen) // 5, 3 * len(curve.seen) // 5)
    assert curve.seen[middle].mean() > 0.9


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "said"),
    few(
        [
            (1_800_167, "beside the clamp"),
            (2_100_106, "plain background"),
            (2_100_107, "plain background"),
        ]
    ),
)
def test_a_line_that_leads_past_the_clamp_is_no_sheet(scenes, known, seed, said):
    """As long as a sheet, and beginning at the jaw, but only a sharp kink leads into the clamp."""
    recipe = replace(scenes.mixed(seed), sheet=False, rolls=False, clutter=3 + seed % 17)
    scene = scenes.make_scene(recipe)
    curve = neutral_curve(scene.image, *known(scene))
    assert not curve.ok
    assert said in curve.why


@pytest.mark.slow
@pytest.mark.parametrize(
    ("beside_px", "ok"), few([(0.0, True), (2.0, True), (7.0, False)], first=2)
)
@pytest.mark.parametrize("hidden_px", few([0.0, 20.0, 30.0], first=2))
def test_a_sheet_that_curves_most_where_its_root_is_hidden_still_leads_to_the_clamp(
    plain, known, beside_px, ok, hidden_px
):
    optics, strip = known(plain)
    u, v = optics.clamp_px
    rolls = ((u + 8, v, hidden_px),) if hidden_px else None
    moved = optics.model_copy(update={"clamp_px": (u, v - beside_px), "rolls_px": rolls})
    curve = neutral_curve(plain.image, moved, strip)
    assert curve.ok is ok
    assert ok or "beside the clamp" in curve.why

"""Straight things through the image: found at the border or beside a curve, and left out."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.vision import neutral_curve
from labrig.vision.curve.background_lines import BackgroundLine
from labrig.vision.image.image import read_grey_image
from labrig.vision.search.ridge_tracing import ridge_maps
from labrig.vision.search.straight_lines import find_branches, find_wires
from tests.cases import few


def drawn(paths, noise=6.0, seed=0):
    """An image (300, 400) with bright lines two pixels wide along some paths [(u, v), ...]."""
    v, u = np.mgrid[0:300, 0:400].astype(float)
    grey = np.full(u.shape, 60.0)
    for (u0, v0), (u1, v1) in paths:
        length = np.hypot(u1 - u0, v1 - v0)
        along = ((u - u0) * (u1 - u0) + (v - v0) * (v1 - v0)) / length
        across = ((v - v0) * (u1 - u0) - (u - u0) * (v1 - v0)) / length
        inside = np.clip(along + 0.5, 0, 1) * np.clip(length - along + 0.5, 0, 1)
        grey += 80 * inside * np.exp(-0.5 * (across / 1.1) ** 2)
    grey += np.random.default_rng(seed).normal(0, noise, grey.shape)
    return np.clip(grey, 0, 255).astype(np.uint8)


def wires_in(image, known, plain, sign=1.0):
    optics, _ = known(plain, image_size=[400, 300])
    picture = read_grey_image(image, optics)
    return find_wires(picture, ridge_maps(picture, 1.9, wide=False), sign)


@pytest.mark.parametrize("noise", [1.0, 16.0])
def test_a_wire_through_the_image_is_found_once_and_to_a_pixel(known, plain, noise):
    line = ((-20.0, 40.0), (430.0, 210.0))
    (wire,) = wires_in(drawn([line], noise), known, plain)
    du, dv = np.subtract(*line[::-1]) / np.hypot(*np.subtract(*line))
    across = (wire.path[:, 1] - line[0][1]) * du - (wire.path[:, 0] - line[0][0]) * dv
    assert np.abs(across).max() < 1
    assert np.ptp(wire.path[:, 0]) > 380
    assert 2.5 < wire.half_px < 4.5


def test_what_ends_before_the_border_is_no_wire(known, plain):
    image = drawn([((20.0, 150.0), (380.0, 120.0))])
    assert wires_in(image, known, plain) == []


def test_neither_is_an_edge_nor_a_line_of_the_other_brightness(known, plain):
    image = drawn([])
    image[:130] += 60
    assert wires_in(image, known, plain) == []
    assert wires_in(drawn([((-20.0, 40.0), (430.0, 210.0))]), known, plain, sign=-1.0) == []


def test_a_wire_that_ends_in_the_image_is_followed_to_its_end(known, plain):
    (wire,) = wires_in(drawn([((410.0, 250.0), (150.0, 90.0))]), known, plain)
    assert wire.path[-1] == pytest.approx([150.0, 90.0], abs=12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "most_px"),
    few(
        [
            (950_396, 0.08),
            (950_299, 0.3),
            *(
                pytest.param(*case, marks=pytest.mark.thorough)
                for case in ((990_058, 0.15), (700_219, 0.15), (700_374, 0.1))
            ),
        ]
    ),
)
def test_a_sheet_is_measured_beside_a_wire_that_crosses_it_at_a_small_angle(
    scenes, known, seed, most_px
):
    scene = scenes.make_scene(scenes.mixed(seed))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < most_px
    # where the wire hides it the band is wide, whatever a face might add everywhere
    seen = np.sqrt(((curve.normal_modes @ curve.covariance) * curve.normal_modes).sum(axis=1))
    assert seen.max() > 1.3 * np.median(seen)


@pytest.mark.slow
@pytest.mark.parametrize("seed", few([950_314, 3_010_129]))
def test_a_sheet_that_a_wire_hides_too_far_is_refused(scenes, known, seed):
    scene = scenes.make_scene(scenes.mixed(seed))
    curve = neutral_curve(scene.image, *known(scene))
    assert not curve.ok
    assert any(said in curve.why for said in ("a wire", "it is known to ±"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "covered"),
    few([(950_110, 0.85), (950_193, 0.85), (1_300_000, 0.8), (1_300_114, 0.8)]),
)
def test_a_straight_sheet_near_the_border_or_a_straight_elongation_is_no_wire(
    scenes, known, seed, covered
):
    scene = scenes.make_scene(scenes.mixed(seed))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.05
    assert curve.covered > covered


def branches_of(curve, lines, known, plain):
    optics, _ = known(plain, image_size=[400, 300])
    picture = read_grey_image(drawn(lines), optics)
    ridges = ridge_maps(picture, 1.9, wide=False)
    seen = np.ones(len(curve) - 1, dtype=bool)
    return find_branches(picture, ridges, 1.0, curve, seen, 12.0)


LINE = ((40.0, 100.0), (340.0, 100.0))  # ends in the picture on both sides


def test_a_line_that_continues_where_the_curve_bends_away_is_found_to_both_its_ends(known, plain):
    t = np.arange(160.0)
    ahead = np.stack([50 + t, np.full(160, 100.0)], axis=1)
    turn = np.arange(1, 90) / 60
    bend = ahead[-1] + 60 * np.stack([np.sin(turn), 1 - np.cos(turn)], axis=1)
    found = branches_of(np.vstack([ahead, bend]), [LINE], known, plain)
    assert len(found) == 1
    ends = np.sort(found[0].path[[0, -1], 0])
    assert ends == pytest.approx([40, 340], abs=14)
    assert np.abs(found[0].path[:, 1] - 100).max() < 1.5


def test_neither_the_sheet_itself_nor_what_ends_at_it_leaves_it(known, plain):
    sheet = np.stack([np.arange(40.0, 341.0), np.full(301, 100.0)], axis=1)
    assert branches_of(sheet, [LINE], known, plain) == []
    assert branches_of(sheet, [LINE, ((200.0, 100.0), (230.0, 112.0))], known, plain) == []


def test_what_begins_at_the_clamp_may_be_the_sheet_though_it_reaches_the_border(known, plain):
    (wire,) = wires_in(drawn([((-20.0, 40.0), (300.0, 140.0))]), known, plain)
    assert wire.begins_at(np.array([5.0, 48.0]), 60.0)
    assert not wire.begins_at(np.array([150.0, 93.0]), 60.0)  # it goes on behind this one
    assert not wire.begins_at(np.array([5.0, 90.0]), 60.0)


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "sheet", "said"),
    [
        (1_500_139, True, "something straight, such as a wire or a shadow, lies along"),
        *(
            pytest.param(seed, False, said, marks=pytest.mark.thorough)
            for seed, said in (
                (1_500_196, "no sheet was found at the clamp"),
                (1_600_022, "the sheet leaves the image"),
            )
        ),
    ],
)
def test_a_path_that_takes_a_line_of_the_clutter_for_the_sheet_is_refused(
    scenes, known, seed, sheet, said
):
    """The first has a wire along a sheet, the others lines that pass near an empty clamp."""
    mixed = scenes.mixed(seed)
    if sheet:
        recipe = replace(mixed, clutter=2 + seed % 10)
    else:
        recipe = replace(mixed, sheet=False, rolls=False, clutter=3 + seed % 17)
    scene = scenes.make_scene(recipe)
    curve = neutral_curve(scene.image, *known(scene))
    assert not curve.ok
    assert said in curve.why


@pytest.mark.thorough
def test_a_lead_from_the_jaw_to_the_border_is_no_face_of_the_sheet_it_runs_with(scenes, known):
    """It begins 4 pixels beside the clamp; the sheet's own end is seen elsewhere."""
    seed = 2_100_151
    scene = scenes.make_scene(replace(scenes.mixed(seed), clutter=2 + seed % 10))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.3
    assert any("such as a wire or a shadow lies along" in said for said in curve.warnings)


@pytest.mark.slow
@pytest.mark.parametrize("spacing", few([40, 47]))
def test_lines_that_cross_the_sheet_steeply_hide_no_more_than_their_crossings(
    scenes, known, spacing
):
    """Graph paper behind the sheet."""
    scene = scenes.make_scene(scenes.Recipe(seed=3, physical=True, snr=30))
    image = scene.image.astype(float)
    image[:, 5::spacing] += 40
    image[5::spacing] += 40
    curve = neutral_curve(np.clip(image, 0, 255).astype(np.uint8), *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.3


@pytest.mark.slow
def test_a_straight_sheet_is_none_where_the_joint_of_the_jaws_continues_behind_the_clamp(
    scenes, known
):
    scene = scenes.make_scene(
        scenes.Recipe(seed=5, turn_rad=0.02, place=(150.0, 240.0), clamp=False)
    )
    image = scene.image.astype(float)
    begin = scene.truth_px[0]
    along = scene.truth_px[40] - begin
    along /= np.hypot(*along)
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]]
    ahead = (columns - begin[0]) * along[0] + (rows - begin[1]) * along[1]
    beside = (rows - begin[1]) * along[0] - (columns - begin[0]) * along[1]
    jaw = (ahead < -1) & (ahead > -120) & (np.abs(beside) < 60)
    image[jaw] = 25 + 100 * np.exp(-0.5 * beside[jaw] ** 2)
    image[np.hypot(ahead - 200, beside) < 20] = 230  # a gap, from which lines are followed
    curve = neutral_curve(np.clip(image, 0, 255).astype(np.uint8), *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.06


@pytest.mark.slow
@pytest.mark.parametrize("seed", few([4_100_024, 4_100_027]))
def test_the_sheets_own_straight_end_is_no_wire(scenes, known, seed):
    """It is seen to where the sheet ends, and nothing goes on there: what is left is not enough."""
    scene = scenes.make_scene(scenes.mixed(seed))
    curve = neutral_curve(scene.image, *known(scene))
    assert curve.ok, curve.why
    assert scenes.rmse_px(curve.points_px, scene.truth_px) < 0.25


@pytest.mark.parametrize(("end", "same"), [(300.0, True), (340.0, False), (150.0, False)])
def test_a_wire_ends_with_a_curve_only_where_both_end(end, same):
    u = np.arange(0.0, end)
    wire = BackgroundLine(np.stack([u, 0 * u + 50], axis=1), np.ones(len(u), dtype=bool), 2.0)
    v = np.arange(100.0, 300.0)
    assert wire.ends_with(np.stack([v, 0 * v + 51], axis=1)) == same

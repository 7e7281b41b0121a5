"""The contact found in the image: rolls, or the crossing of the arc."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.vision import contact_from_image, neutral_curve


def look(scene, known, **changes):
    """Curve, and the radius and position on it of the rolls (or of 80 % of the sheet)."""
    scene.optics.pop("rolls_px", None)  # they are to be found
    optics, strip = known(scene, **changes)
    curve = neutral_curve(scene.image, optics, strip)
    assert curve.ok, curve.why
    truth = scene.truth_mm / 1000
    middle = truth[int(0.8 * len(truth))]
    if scene.rolls_px:
        middle = optics.pixel_to_world(np.array(scene.rolls_px)[:, :2]).mean(axis=0)
    radius = float(np.hypot(*middle))
    return optics, curve, radius, radius * float(np.arctan2(middle[1], middle[0]))


@pytest.fixture(scope="module")
def rolled(scenes):
    """A sheet between two rolls."""
    return scenes.make_scene(scenes.Recipe(seed=15, physical=True, rolls=True, snr=20))


@pytest.mark.slow
def test_both_rolls_are_found_and_the_contact_is_between_them(rolled, known):
    optics, curve, radius, position = look(rolled, known)
    contact = contact_from_image(rolled.image, curve, optics, radius)
    truth = optics.pixel_to_world(np.array(rolled.rolls_px)[:, :2])
    found = np.array(contact.rolls_m)[:, :2]
    apart = np.hypot(*(found[:, None] - truth[None]).transpose(2, 0, 1)).min(axis=1)
    assert (apart * optics.px_per_m < 0.6).all()
    assert contact.position_m == pytest.approx(position, abs=4 * contact.position_sigma_m)
    assert contact.radius_m == pytest.approx(radius, abs=0.1e-3)
    assert contact.position_sigma_m < 0.1e-3
    slope = np.interp(contact.s_m, curve.s_m, np.gradient(curve.y_m, curve.x_m))
    assert np.tan(contact.angle_rad) == pytest.approx(slope, abs=0.02)


def test_the_arcs_origin_is_where_positions_count_from(rolled, known):
    optics, curve, radius, position = look(rolled, known)
    turned = contact_from_image(rolled.image, curve, optics, radius, 0.1)
    assert turned.position_m == pytest.approx(position - 0.1 * radius, abs=0.1e-3)


def test_rolls_that_the_optics_name_are_taken(rolled, known):
    scene = replace(rolled, rolls_px=rolled.rolls_px)
    optics, curve, radius, _ = look(scene, known)
    named = tuple((u + 0.8, v, r) for u, v, r in scene.rolls_px)
    contact = contact_from_image(
        scene.image, curve, optics.model_copy(update={"rolls_px": named}), radius
    )
    centres = optics.pixel_to_world([(u, v) for u, v, _ in named])
    assert np.array(contact.rolls_m)[:, :2] == pytest.approx(centres)


def test_without_rolls_the_crossing_of_the_arc_is_the_contact(plain, known):
    optics, curve, radius, position = look(plain, known)
    contact = contact_from_image(plain.image, curve, optics, radius)
    assert contact.rolls_m == ()
    assert contact.radius_m == pytest.approx(radius, abs=1e-6)
    assert contact.position_m == pytest.approx(position, abs=4 * contact.position_sigma_m)


def test_a_sheet_that_ends_before_the_arc_has_no_contact(plain, known):
    optics, curve, _, _ = look(plain, known)
    assert contact_from_image(plain.image, curve, optics, 0.06) is None


def test_without_a_curve_there_is_no_contact(plain, known):
    optics, strip = known(plain)
    black = np.zeros_like(plain.image)
    assert contact_from_image(black, neutral_curve(black, optics, strip), optics, 0.04) is None


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize("count", [16, pytest.param(40, marks=pytest.mark.thorough)])
def test_no_rolls_are_seen_where_there_are_none_and_none_are_misplaced(scenes, known, count):
    found = offered = 0
    for seed in range(820_000, 820_000 + count):
        try:
            scene = scenes.make_scene(scenes.mixed(seed))
        except RuntimeError:
            continue
        scene.optics.pop("rolls_px", None)
        optics, strip = known(scene)
        curve = neutral_curve(scene.image, optics, strip)
        if not curve.ok:
            continue
        middle = scene.truth_mm[int(0.8 * len(scene.truth_mm))] / 1000
        truth = np.empty((0, 2))
        if scene.rolls_px:
            truth = optics.pixel_to_world(np.array(scene.rolls_px)[:, :2])
            middle = truth.mean(axis=0)
            offered += 1
        radius = float(np.hypot(*middle))
        expected = radius * float(np.arctan2(middle[1], middle[0]))
        contact = contact_from_image(scene.image, curve, optics, radius, expected_m=expected)
        if contact is None or not contact.rolls_m:
            continue
        assert len(truth), seed
        centres = np.array(contact.rolls_m)[:, :2]
        apart = np.hypot(*(centres[:, None] - truth[None]).transpose(2, 0, 1)).min(axis=1)
        assert (apart * optics.px_per_m < 2).all(), seed
        found += 1
    # rolls as bright as the background, or behind a holder, are not seen
    assert found > 0.6 * offered

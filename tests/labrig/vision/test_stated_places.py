"""Places on a strip, and its tip, that are stated: the curve passes them and ends there."""

import json

import cv2
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.vision import neutral_curve
from labrig.vision.curve.shape import make_basis, make_shape
from labrig.vision.extraction.path_fit import fit_path
from labrig.vision.fit.stated_places import StatedPlaces
from tests.labrig.vision.test_outline import CLAMP, UNKNOWN, arc, beside, beside_px, drawn, stated

pytestmark = pytest.mark.slow
FAINT, CLEAR = arc(150, 0.8), arc(150, -0.9)


def at(line, share):
    u, v = line[round(share * (len(line) - 1))]
    return (round(float(u), 1), round(float(v), 1))


@pytest.fixture(scope="module")
def forked():
    """A faint strip and a clear one that leave the clamp together."""
    clear = drawn(CLEAR, 6, noise=0.0).astype(float)
    faint = drawn(FAINT, 6, light=110.0).astype(float)
    return np.maximum(clear, faint).astype(np.uint8)


def test_the_curve_passes_the_places_that_are_stated(forked):
    away = neutral_curve(forked, stated(), UNKNOWN)
    assert not away.ok or beside_px(away, FAINT).max() > 10
    through = tuple(at(FAINT, share) for share in (0.2, 0.3, 0.6))
    places = stated(through_px=through, tip_px=at(FAINT, 1.0))
    curve = neutral_curve(forked, places, UNKNOWN)
    assert curve.ok, curve.why
    error = beside_px(curve, FAINT)
    assert error.max() < 3.0  # at the fork both share an edge
    assert error[len(error) // 3 :].max() < 0.5
    assert curve.s_m[-1] * 2000 == pytest.approx(150, abs=4)


@pytest.mark.thorough
def test_a_strip_ends_where_its_tip_is_stated_though_it_looks_as_if_it_went_on():
    line = arc(160, 0.8)
    curve = neutral_curve(drawn(line, 6), stated(tip_px=at(line, 0.6)), UNKNOWN)
    assert curve.ok, curve.why
    assert curve.s_m[-1] * 2000 == pytest.approx(96, abs=2)
    assert 2000 * curve.end_sigma_m == pytest.approx(3.0)
    assert any("to the stated tip" in text for text in curve.warnings)


def test_a_stated_tip_is_placed_better_where_the_strip_is_seen_to_end():
    line = arc(150, 0.8)
    curve = neutral_curve(drawn(line, 6), stated(tip_px=at(line, 0.985)), UNKNOWN)
    assert curve.ok, curve.why
    assert curve.s_m[-1] * 2000 == pytest.approx(150, abs=3)
    assert 2000 * curve.end_sigma_m < 3.0


def test_a_place_where_nothing_shows_the_strip_says_where_it_is():
    line = arc(150, 0.8)
    _, along = beside(line)
    image = np.where((along > 0.35) & (along < 0.65), 60, drawn(line, 6)).astype(np.uint8)
    tip = {"tip_px": at(line, 1.0)}
    without = neutral_curve(image, stated(**tip), UNKNOWN)
    curve = neutral_curve(image, stated(through_px=(at(line, 0.5),), **tip), UNKNOWN)
    assert curve.ok, curve.why
    middle = len(curve.sigma_m) // 2
    assert not curve.seen[middle]
    assert beside_px(curve, line).max() < 2.0
    assert 2000 * curve.sigma_m[middle] < 2.0
    assert not without.ok or 2000 * without.sigma_m[middle] > 2 * 2000 * curve.sigma_m[middle]


def test_a_place_beside_the_strip_is_named_not_followed():
    line = arc(150, 0.8)
    u, v = at(line, 0.5)
    places = {"through_px": ((u + 15, v - 25),), "tip_px": at(line, 1.0)}
    curve = neutral_curve(drawn(line, 6), stated(**places), UNKNOWN)
    assert not curve.ok
    if "stated places" in curve.why:
        assert f"{u + 15:.0f},{v - 25:.0f}" in curve.why


def test_the_curve_begins_at_the_stated_clamp_though_the_strip_is_seen_further_on_only():
    line = arc(150, 0.8)
    _, along = beside(line)
    image = np.where(along < 0.05, 60, drawn(line, 6)).astype(np.uint8)
    through = tuple(at(line, share) for share in (0.3, 0.6))
    curve = neutral_curve(image, stated(through_px=through, tip_px=at(line, 1.0)), UNKNOWN)
    assert curve.ok, curve.why
    assert np.hypot(*(curve.points_px[0] - CLAMP)) < 1.5
    assert curve.s_m[-1] * 2000 == pytest.approx(150, abs=3)


def lost_in_noise(line, seed):
    """A strip two pixels thick, twice as bright over its ground as one pixel's noise."""
    across, _ = beside(line)
    strip = 24.0 * np.clip(1.5 - np.abs(across), 0, 1)
    grey = 90 + strip + np.random.default_rng(seed).normal(0, 12, strip.shape)
    return np.clip(np.round(grey), 0, 255).astype(np.uint8)


def test_a_thin_strip_whose_edges_are_lost_in_noise_follows_the_path_through_the_places():
    line = arc(150, 0.8)
    image = lost_in_noise(line, 4)
    tip = {"tip_px": at(line, 1.0)}
    through = tuple(at(line, share) for share in (0.25, 0.5, 0.75))
    curve = neutral_curve(image, stated(through_px=through, **tip), UNKNOWN)
    assert curve.ok, curve.why
    assert any("too faint to be measured" in text for text in curve.warnings)
    assert not curve.seen.any()
    error, sigma = beside_px(curve, line), 2000 * curve.sigma_m
    assert error.max() < 2.0
    assert sigma.min() > 1.4
    assert curve.covered == 0.0
    assert not neutral_curve(image, stated(**tip), UNKNOWN).ok  # a tip alone says too little


def test_where_paths_through_the_same_places_part_the_strip_is_known_to_half_of_that():
    basis = make_basis(100.0, 100.0, 12, 1.0)
    shape = make_shape(basis, np.zeros(2), 0.0, np.zeros(basis.size))
    straight = np.stack([np.linspace(0, 100, 201), np.zeros(201)], axis=1)
    other = straight + np.stack([np.zeros(201), 8 * np.sin(np.linspace(0, np.pi, 201))], axis=1)
    places = StatedPlaces(
        clamp_px=np.zeros(2), clamp_sigma_px=1.0, on_strip_px=np.array([[100.0, 0.0]]), sigma_px=1.5
    )

    def sigma(others):
        fit = fit_path(
            shape,
            straight,
            width_px=3.0,
            clearness=3.0,
            prior=np.array([3.0, 0.4]),
            places=places,
            others_px=others,
        )
        return fit.inner_sigma_px

    alone, parted = sigma([]), sigma([other])
    assert alone.max() < 2.0
    assert parted[50] == pytest.approx(np.hypot(alone[50], 4.0), rel=0.05)
    assert parted[0] == pytest.approx(alone[0], rel=0.05)


def test_places_far_from_the_curve_widen_its_uncertainty():
    basis = make_basis(100.0, 100.0, 12, 1.0)
    shape = make_shape(basis, np.zeros(2), 0.0, np.zeros(basis.size))

    def apart(aside_px):
        on_strip = np.array([[30.0, aside_px], [60.0, -aside_px]])
        places = StatedPlaces(
            clamp_px=np.zeros(2), clamp_sigma_px=1.0, on_strip_px=on_strip, sigma_px=1.5
        )
        return places.apart_px(shape)

    assert apart(1.0) == 0.0
    assert apart(2.5) == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize("place", [(9999.0, 5.0), (50.0, -1.0)])
def test_a_place_outside_of_the_image_is_named(forked, place):
    curve = neutral_curve(forked, stated(tip_px=place), UNKNOWN)
    assert f"{place[0]:g},{place[1]:g} lies outside of the image of 220 x 150 pixels" in curve.why


def test_places_where_there_is_nothing_are_refused_with_what_to_do():
    empty = np.random.default_rng(1).normal(90, 6, (150, 220)).astype(np.uint8)
    curve = neutral_curve(empty, stated(through_px=((90.0, 90.0),), tip_px=(150.0, 70.0)), UNKNOWN)
    assert not curve.ok
    assert "--along-px" not in curve.why  # a direction would not help
    assert "places" in curve.why


@pytest.fixture
def photograph(tmp_path, forked):
    cv2.imwrite(str(tmp_path / "fork.png"), forked)
    optics = {"px_per_mm": 2.0, "clamp_px": CLAMP, "clamp_angle_known": False}
    (tmp_path / "optics.json").write_text(json.dumps(optics))
    return tmp_path / "fork.png"


def pixel(place):
    return f"{place[0]},{place[1]}"


def test_on_the_command_line_places_and_tip_need_no_sheet(photograph, capsys):
    through = " ".join(pixel(at(FAINT, share)) for share in (0.2, 0.3, 0.6))
    command = ["curves", str(photograph), "--through", through, "--tip-px", pixel(at(FAINT, 1.0))]
    assert run([*command, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["ok"]
    points = np.array(said["points_px"])
    gap = np.hypot(*(points[:, None] - FAINT[None]).transpose(2, 0, 1)).min(axis=1)
    assert gap[len(gap) // 3 : -3].max() < 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--through", "12,13 14"], "--through '14': give columns and rows of pixels"),
        (["--tip-px", "12"], "--tip-px '12': give a pixel's column and row"),
        (["--tip-px", "1,2", "--strip", "a=3,4"], "--through and --tip-px are for one strip"),
    ],
)
def test_what_is_no_place_is_said(photograph, capsys, options, said):
    assert run(["curves", str(photograph), *options]) == 2
    assert said in capsys.readouterr().err


def test_of_several_strips_each_states_its_own_places(photograph, capsys):
    strips = {"a": {"clamp_px": CLAMP, "tip_px": at(FAINT, 1.0)}}
    strips["a"]["through_px"] = [at(FAINT, 0.5)]
    optics = {"px_per_mm": 2.0, "clamp_px": CLAMP, "clamp_angle_known": False, "strips": strips}
    file = photograph.with_name("optics.json")
    file.write_text(json.dumps(optics))
    assert run(["curves", str(photograph)]) == 0
    assert "fork:a: 7" in capsys.readouterr().out
    file.write_text(json.dumps(optics | {"tip_px": [3, 4]}))
    assert run(["curves", str(photograph)]) == 2
    assert "each states its own through_px and tip_px" in capsys.readouterr().err

"""Strips of which little is stated, or that are thick, short, shaded or in colour."""

import dataclasses
import functools

import numpy as np
import pytest

from drivers.plugins import Part
from labrig.vision import NeutralCurve, Optics, StripGeometry, neutral_curve
from labrig.vision.calibration.optics import ColourChannel
from labrig.vision.checks import catalogue
from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding
from labrig.vision.curve.shape import make_basis, make_shape
from labrig.vision.fit.outline import fit_outline
from labrig.vision.fit.outline_blocks import measure_blocks, without_lonely
from labrig.vision.fit.stated_places import StatedPlaces
from labrig.vision.fit.thickness import visible_thickness_m
from labrig.vision.image.downscaling import in_camera_pixels
from labrig.vision.image.image import in_levels, read_grey_image
from labrig.vision.image.overlay import picture_with
from labrig.vision.search.work import OutlineWork
from tests.cases import few

SIZE = (150, 220)  # rows, columns
CLAMP = (30.0, 110.0)
UNKNOWN = StripGeometry(free_length_m=0.05, thickness_known=False, length_known=False)


pytestmark = pytest.mark.slow


def arc(length_px, turn_rad, heading_rad=-0.3):
    """The middle line of a strip that bends evenly, in pixels from the clamp on."""
    phi = heading_rad + turn_rad * np.linspace(0, 1, 2001)
    step = length_px / 2000
    u = CLAMP[0] + np.concatenate([[0.0], np.cumsum(np.cos(phi[1:]) * step)])
    v = CLAMP[1] + np.concatenate([[0.0], np.cumsum(np.sin(phi[1:]) * step)])
    return np.stack([u, v], axis=1)


def beside(line):
    """How far each pixel lies beside a line, and how far along it (0 to 1)."""
    return _beside(line.tobytes())


@functools.cache
def _beside(drawn_line):
    line = np.frombuffer(drawn_line).reshape(-1, 2)
    rows, columns = np.mgrid[0 : SIZE[0], 0 : SIZE[1]]
    places = np.stack([columns.ravel(), rows.ravel()], axis=1).astype(float)
    few = line[::10]
    nearest = ((places[:, None] - few[None]) ** 2).sum(axis=2).argmin(axis=1) * 10
    along = np.gradient(line, axis=0)[nearest]
    along /= np.hypot(*along.T)[:, None]
    gap = places - line[nearest]
    across = gap[:, 1] * along[:, 0] - gap[:, 0] * along[:, 1]
    ahead = (gap * along).sum(axis=1)
    inside = (np.abs(ahead) < 2) | ((nearest > 0) & (nearest < len(line) - 1))
    return (
        np.where(inside, across, 1e3).reshape(SIZE),
        (nearest / (len(line) - 1)).reshape(SIZE),
    )


def drawn(line, thick_px, light=200.0, ground=60.0, noise=2.0):
    """A strip on plain ground; `light` is a number or (rows, columns)."""
    across, _ = beside(line)
    share = np.clip(thick_px / 2 - np.abs(across) + 0.5, 0, 1)
    grey = ground + share * (light - ground)
    grey = grey + np.random.default_rng(5).normal(0, noise, SIZE)
    return np.clip(np.round(grey), 0, 255).astype(np.uint8)


def stated(clamp=CLAMP, **more):
    return Optics(px_per_mm=2.0, clamp_px=clamp, clamp_angle_known=False, **more)


def beside_px(curve, line):
    gap = np.hypot(*(curve.points_px[:, None] - line[None]).transpose(2, 0, 1))
    return gap.min(axis=1)[3:-3]


@pytest.mark.parametrize(
    ("length_px", "thick_px"),
    [(150, 5), *(pytest.param(*one, marks=pytest.mark.thorough) for one in ((132, 22), (140, 14)))],
)
def test_clamp_and_ruler_are_enough_for_thin_and_thick_strips(length_px, thick_px):
    line = arc(length_px, 0.8)
    curve = neutral_curve(drawn(line, thick_px), stated(), UNKNOWN)
    assert curve.ok, curve.why
    assert beside_px(curve, line).max() < 0.05 * thick_px + 0.3
    assert curve.s_m[-1] * 2000 == pytest.approx(length_px, abs=0.15 * thick_px + 3)
    assert curve.thickness_m * 2000 == pytest.approx(thick_px, rel=0.15)
    said = next(text for text in curve.warnings if "not stated" in text)
    assert "thickness" in said
    assert "length" in said
    assert "direction at the clamp" in said


@pytest.mark.thorough
def test_the_clamp_within_20_pixels_is_enough():
    line = arc(150, 0.8)
    curve = neutral_curve(drawn(line, 6), stated((CLAMP[0] + 9, CLAMP[1] + 14)), UNKNOWN)
    assert curve.ok, curve.why
    assert beside_px(curve, line).max() < 0.6


def of_length(length_px, **known):
    """What is stated of a strip that is as long as that at 2 pixels a millimetre."""
    optics = Optics(px_per_mm=2.0, clamp_px=CLAMP, roll_rad=-0.3, clamp_angle_sigma_rad=0.1)
    strip = dataclasses.replace(UNKNOWN, free_length_m=length_px / 2000, length_known=True)
    return optics, dataclasses.replace(strip, **known)


@pytest.mark.parametrize("thick_px", [5, pytest.param(14, marks=pytest.mark.thorough)])
def test_a_stated_length_takes_the_place_of_an_end_that_is_seen_nearby(thick_px):
    line = arc(150, 0.8)
    image = drawn(line, thick_px)
    curve = neutral_curve(image, *of_length(140))  # such as before a fitting at the tip
    assert curve.ok, curve.why
    assert curve.s_m[-1] * 2000 == pytest.approx(140, abs=0.5)
    assert beside_px(curve, line).max() < 0.6
    assert any("after the stated 70.0 mm" in text for text in curve.warnings)
    as_stated = neutral_curve(image, *of_length(150))
    assert not any("the stated 75.0 mm" in text for text in as_stated.warnings)


def hook(length_px, share, radius_px, turn_rad, heading_rad=-0.3):
    """A line that is straight up to a share of its length, turns on a circle, and goes on so."""
    s = np.linspace(0, length_px, 600)
    phi = heading_rad + np.clip((s - share * length_px) / radius_px, 0, turn_rad)
    steps = np.stack([np.cos(phi), np.sin(phi)], axis=1)[1:] * np.diff(s)[:, None]
    return np.array(CLAMP) + np.concatenate([[[0, 0]], np.cumsum(steps, axis=0)])


@pytest.mark.thorough
def test_a_strip_of_a_stated_length_is_followed_around_a_hook():
    line = hook(140, 0.55, 10, 2.6)
    curve = neutral_curve(drawn(line, 8), *of_length(140))
    assert curve.ok, curve.why
    assert beside_px(curve, line).max() < 0.8
    assert curve.s_m[-1] * 2000 == pytest.approx(140, abs=0.5)


def test_a_strip_that_ends_far_from_its_stated_length_is_refused():
    line = arc(150, 0.8)
    assert "before the stated" in neutral_curve(drawn(line, 14), *of_length(200)).why
    # what a thin one goes on as is often a wire
    assert "mm after the stated 67.5 mm" in neutral_curve(drawn(line, 6), *of_length(135)).why
    # how far it goes on is not known where its end was not looked for
    further = neutral_curve(drawn(line, 6), *of_length(110)).why
    assert "the strip goes on for at least" in further
    assert "mm beyond the stated 55.0 mm" in further


@pytest.mark.thorough
def test_a_curve_that_leaves_the_clamp_in_another_direction_than_stated_is_refused():
    line = arc(150, 0.8)
    image = drawn(line, 6)
    optics = Optics(px_per_mm=2.0, clamp_px=CLAMP, roll_rad=-0.3, clamp_angle_sigma_rad=0.1)
    assert neutral_curve(image, optics, UNKNOWN).ok
    turned = optics.model_copy(update={"roll_rad": 0.2})
    found = neutral_curve(image, turned, UNKNOWN)
    assert "stated direction" in found.why


@pytest.mark.thorough
def test_a_path_of_which_both_edges_are_nowhere_measured_is_no_strip():
    image = read_grey_image(drawn(arc(150, 0.0, heading_rad=0.0), 10), stated())
    basis = make_basis(120.0, 120.0, 6, 1.0)
    shape = make_shape(basis, np.zeros(2), 0.0, np.zeros(basis.size))

    def faint(_shape, _taper, blocks):
        return dataclasses.replace(blocks, by_profile=blocks.seen)

    def fitted(completed):
        return fit_outline(
            shape,
            [image],
            stated(),
            width_px=10,
            prior=np.array([3.0, 0.2]),
            work=OutlineWork(),
            completed=completed,
        )

    assert fitted(None) is not None
    assert fitted(faint) is None


def test_where_the_begin_is_hidden_the_clamp_leads_unless_it_is_stated_roughly():
    basis = make_basis(120.0, 120.0, 6, 1.0)
    hidden_px = 25.0
    shape = make_shape(basis, np.array([-hidden_px, 0.0]), 0.0, np.zeros(basis.size))
    image = read_grey_image(drawn(arc(150, 0.0, heading_rad=0.0), 10), stated())

    def begin_px(aside_px, sigma_px):
        clamp = StatedPlaces(
            clamp_px=np.array([-hidden_px, aside_px]),
            clamp_sigma_px=sigma_px,
            on_strip_px=np.empty((0, 2)),
            sigma_px=1.5,
        )
        prior = np.array([3.0, 0.2])
        fit = fit_outline(
            shape, [image], stated(), width_px=10, prior=prior, work=OutlineWork(), places=clamp
        )
        return fit.shape.y[0]

    assert 0.1 < begin_px(0.8, 0.4) < 0.8  # a straight strip says most of it
    assert begin_px(9.0, 0.4) == pytest.approx(0.0, abs=0.05)  # too far aside to be meant


def test_what_is_stated_keeps_the_coordinates_where_they_are():
    """The x axis begins at the stated clamp, wherever the strip was found to begin."""
    line = arc(150, 0.8)
    aside = (CLAMP[0], CLAMP[1] + 8.0)
    curve = neutral_curve(drawn(line, 6), stated(aside), UNKNOWN)
    assert curve.y_m[0] * 2000 == pytest.approx(8.0, abs=1.5)
    assert np.allclose(
        stated(aside).world_to_pixel(np.stack([curve.x_m, curve.y_m], axis=1)), curve.points_px
    )


@pytest.mark.thorough
def test_half_in_shade_or_darker_further_on_it_is_the_same_strip():
    line = arc(140, 0.8)
    across, along = beside(line)
    shaded = np.where(across < 0, 170.0, 20.0)  # brighter than the ground, and darker
    changing = np.where(along < 0.5, shaded, np.where(across < 0, 30.0, 10.0))
    curve = neutral_curve(drawn(line, 12, changing, ground=90.0), stated(), UNKNOWN)
    assert curve.ok, curve.why
    error = beside_px(curve, line)
    assert error.max() < 1.0
    assert (curve.sigma_m.max() * 2000) > error.max() / 3


def test_dirt_in_a_gap_does_not_make_the_strip_seen_there():
    line = arc(150, 0.8)
    image = drawn(line, 10)
    _, along = beside(line)
    piece = np.abs((along - 0.36) % 0.1 - 0.05) < 0.007
    image[(along > 0.36) & (along < 0.66) & ~piece] = 60
    curve = neutral_curve(image, stated(), UNKNOWN)
    at = np.linspace(0, 1, len(curve.s_m)) if curve.ok else np.empty(0)
    assert not curve.ok or not curve.seen[(at > 0.46) & (at < 0.58)].any()


@pytest.mark.parametrize(
    ("thick_px", "thinner"),
    few([(12, lambda along: 0.5 * (along > 0.5)), (16, lambda along: 0.7 * along)]),
    ids=["half as thick from the middle on", "tapers"],
)
def test_a_strip_that_becomes_thinner_is_followed_in_its_own_width(thick_px, thinner):
    line = arc(150, 0.8)
    _, along = beside(line)
    curve = neutral_curve(drawn(line, thick_px * (1 - thinner(along))), stated(), UNKNOWN)
    assert curve.ok, curve.why
    assert beside_px(curve, line).max() < 0.3


def test_a_bridged_stretch_is_known_less_well():
    line = arc(150, 0.8)
    image = drawn(line, 10)
    _, along = beside(line)
    image[(along > 0.45) & (along < 0.62)] = 60
    curve = neutral_curve(image, stated(), UNKNOWN)
    assert curve.ok, curve.why
    at = np.linspace(0, 1, len(curve.s_m))
    bridged = (at > 0.5) & (at < 0.57)
    assert not curve.seen[bridged].any()
    assert curve.sigma_m[bridged].min() > 1.3 * np.median(curve.sigma_m[curve.seen])


def test_a_refusal_for_one_place_says_and_shows_where_it_is(tmp_path):
    line = arc(150, 0.8)
    image = drawn(line, 10)
    _, along = beside(line)
    image[(along > 0.25) & (along < 0.75)] = 60
    curve = neutral_curve(image, stated(tip_px=tuple(line[-1])), UNKNOWN)
    assert curve.why.startswith("check of hidden parts failed")
    middle = line[len(line) // 2]
    assert np.hypot(*(np.array(curve.refused_at_px) - middle)) < 15
    assert "Look near {:.0f},{:.0f}.".format(*curve.refused_at_px) in curve.why
    drawing = picture_with(image, [curve], long_side_px=2 * max(SIZE))
    yellow = np.argwhere((drawing[:, :, 2] > 200) & (drawing[:, :, 0] < 60))[:, ::-1] / 2
    assert np.abs(yellow.mean(axis=0) - curve.refused_at_px).max() < 1.5


@pytest.mark.parametrize("by", [1, 2])
def test_its_place_is_one_of_the_picture_as_taken(by):
    curve = NeutralCurve(ok=False, why="too faint.", refused_at_px=(20.0, 10.0))
    assert in_camera_pixels(curve, by).refused_at_px == (20.5 * by - 0.5, 10.5 * by - 0.5)


@pytest.mark.thorough
@pytest.mark.parametrize("hides", [pytest.param("mask", marks=pytest.mark.thorough), "roll"])
def test_what_hides_a_strip_is_not_the_border_of_the_image(hides):
    line = arc(150, 0.8)
    u, v = line[len(line) // 2]
    facts = {"mask_px": [[(u - 9, 40.0), (u + 9, 40.0), (u + 9, 190.0), (u - 9, 190.0)]]}
    rolls = {"rolls_px": ((u, v - 12, 11.0), (u, v + 12, 11.0))}
    image = drawn(line, 5)
    curve = neutral_curve(image, stated(**(facts if hides == "mask" else rolls)), UNKNOWN)
    assert curve.ok, curve.why
    assert curve.s_m[-1] * 2000 == pytest.approx(150, abs=3)
    assert beside_px(curve, line).max() < 0.8
    assert not any("border" in text for text in curve.warnings)


@pytest.mark.thorough
def test_a_strip_that_ends_under_a_mask_ends_where_it_is_seen_last():
    line = arc(150, 0.8)
    u, v = line[int(0.8 * len(line))]
    mask = [[(u, v - 40), (u + 60, v - 40), (u + 60, v + 60), (u, v + 60)]]
    curve = neutral_curve(drawn(line, 5), stated(mask_px=mask), UNKNOWN)
    assert curve.ok, curve.why
    assert curve.s_m[-1] * 2000 == pytest.approx(120, abs=4)
    assert not any("border" in text for text in curve.warnings)


@pytest.mark.parametrize(("thick_px", "turn_rad"), [(16, 0.3), (6, 1.0)])
def test_a_strip_that_leaves_the_image_is_followed_up_to_the_border(thick_px, turn_rad):
    """One of its edges leaves the image before its middle does."""
    line = arc(260, turn_rad)
    curve = neutral_curve(drawn(line, thick_px), stated(), UNKNOWN)
    assert curve.ok, curve.why
    assert any("to the border of the image" in text for text in curve.warnings)
    u, v = curve.points_px[-1]
    assert min(u, v, SIZE[1] - 1 - u, SIZE[0] - 1 - v) < 1.1
    assert beside_px(curve, line).max() < 0.05 * thick_px + 0.3


def test_a_strip_that_ends_shortly_before_the_border_is_not_led_on_to_it():
    line = arc(134, 0.0, heading_rad=-0.9)  # its middle would leave the image after 140
    curve = neutral_curve(drawn(line, 24), stated(), UNKNOWN)
    assert curve.ok, curve.why
    assert curve.s_m[-1] * 2000 < 137


def test_a_strip_on_white_paper():
    line = arc(150, 0.8)
    image = drawn(line, 4, light=40.0, ground=300.0)
    assert (image == 255).mean() > 0.9
    curve = neutral_curve(image, stated(), UNKNOWN)
    assert curve.ok, curve.why
    assert beside_px(curve, line).max() < 0.6


def coloured(line, thick_px):
    """A strip that differs from its ground in colour, and not in brightness: (blue, green, red)."""
    across, _ = beside(line)
    share = np.clip(thick_px / 2 - np.abs(across) + 0.5, 0, 1)[:, :, None]
    ground, strip = np.array([120.0, 110.0, 80.0]), np.array([120.0, 72.0, 155.0])
    image = ground + share * (strip - ground)
    image += np.random.default_rng(2).normal(0, 2, image.shape)
    return np.clip(np.round(image), 0, 255).astype(np.uint8)


@pytest.mark.thorough
def test_a_strip_that_differs_in_colour_only_is_found():
    line = arc(140, 0.8)
    curve = neutral_curve(coloured(line, 10), stated(), UNKNOWN)
    assert curve.ok, curve.why
    assert beside_px(curve, line).max() < 0.8
    assert any("differences of colours were used" in text for text in curve.warnings)


@pytest.mark.thorough
def test_a_channel_may_be_chosen():
    line = arc(140, 0.8)
    image = coloured(line, 10)
    assert not neutral_curve(image, stated(channel=ColourChannel.GREY), UNKNOWN).ok
    curve = neutral_curve(image, stated(channel=ColourChannel.RED), UNKNOWN)
    assert curve.ok, curve.why
    assert not any("colour" in text for text in curve.warnings)


@pytest.mark.parametrize("full", [255, 1.0])
def test_transparent_ground_is_white(full):
    """Of floats from 0 to 1 it was 255 times as transparent."""
    line = arc(140, 0.8)
    across, _ = beside(line)
    image = np.zeros((*SIZE, 4), np.uint8 if full == 255 else np.float64)
    image[:, :, 3] = full * (np.abs(across) < 6)
    curve = neutral_curve(in_levels(image, stated()), stated(), UNKNOWN)
    assert curve.ok, curve.why
    assert curve.polarity == "dark"


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in (2, 3))]
)
def test_noise_is_no_strip_and_the_refusal_says_what_to_do(seed):
    noise = np.random.default_rng(seed).normal(90, 6, SIZE).astype(np.uint8)
    curve = neutral_curve(noise, stated(), UNKNOWN)
    assert not curve.ok
    assert curve.why.startswith(("search failed: ", "check of the "))
    assert any(remedy in curve.why for remedy in ("--along-px", "clamp_px", "visible"))


@pytest.mark.parametrize(("said_px", "side"), few([(150, "before"), (95, "after")]))
def test_a_strip_of_another_length_than_stated_is_refused(said_px, side):
    line = arc(120, 0.8)
    strip = StripGeometry(free_length_m=said_px / 2000, thickness_m=12 / 2000)
    curve = neutral_curve(drawn(line, 12), stated(), strip)
    assert not curve.ok
    assert side in curve.why or "end" in curve.why


def beside_its_shade(line, thick_px):
    """A tube lit from one side: as clear as its dark edge is the edge of its shade."""
    across, _ = beside(line)
    light = np.where(across < 0.1 * thick_px, 230.0, 130.0)
    return drawn(line, thick_px, light, ground=30.0)


@pytest.mark.thorough
def test_where_another_edge_is_as_clear_no_curve_is_known_well():
    line = arc(140, 0.5)
    curve = neutral_curve(beside_its_shade(line, 20), stated(), UNKNOWN)
    if curve.ok:
        assert beside_px(curve, line).max() < max(1.0, 3 * curve.sigma_m.max() * 2000)
    else:
        assert "check of the" in curve.why or "search failed" in curve.why


@pytest.mark.thorough
def test_a_strip_longer_than_the_image_is_wide_is_followed_to_its_end():
    line = arc(300, 5.2, heading_rad=-1.2)
    line = line - line.min(axis=0) + 16
    curve = neutral_curve(drawn(line, 6), stated(tuple(line[0])), UNKNOWN)
    assert curve.ok, curve.why
    assert curve.s_m[-1] * 2000 == pytest.approx(300, rel=0.05)


def test_of_two_strips_the_one_at_the_clamp_is_meant():
    line = arc(150, 0.4)
    other = line - [0.0, 14.0]
    image = np.maximum(drawn(line, 4, light=150.0), drawn(other, 4, light=210.0))
    curve = neutral_curve(image, stated(), UNKNOWN)
    assert curve.ok, curve.why
    assert beside_px(curve, line).max() < 1.0


class Extra(CurveCheck):
    """A check of another distribution that says the same of every curve."""

    def finding(self, seen):
        """See `CurveCheck.finding`."""
        assert seen.fit.shape.x.shape == seen.sigma_px.shape
        assert seen.context.optics.px_per_mm == 2.0
        assert seen.context.nodes_px(seen.fit.shape).shape == (len(seen.sigma_px), 2)
        assert 0 < seen.covered <= 1
        assert seen.length_mm > 0
        wide = np.full(len(seen.sigma_px), 1.0)
        return CurveFinding(
            refusal=self.refusal, warning=self.warning, widening_px=wide, end_widening_px=30.0
        )


@pytest.mark.usefixtures("one_look")
@pytest.mark.parametrize(
    "stage",
    few(
        [
            CheckStage.CHOSEN,
            CheckStage.OUTLINE,
            pytest.param(CheckStage.CANDIDATE, marks=pytest.mark.thorough),
            pytest.param(CheckStage.UNCERTAINTY, marks=pytest.mark.thorough),
        ]
    ),
)
def test_checks_of_other_distributions_are_asked_for_a_curve_between_edges(monkeypatch, stage):
    image, told = drawn(arc(140, 0.8), 14), (stated(), UNKNOWN)
    without = neutral_curve(image, *told)

    def with_check(**said):
        check = Extra(name="extra", looks_at="nothing", stage=stage, order=1, **said)
        parts = catalogue.FOLDER.parts() | {"extra": Part("extra", check, "labrig-extra", "0.1")}
        monkeypatch.setattr(catalogue, "FOLDER", type("F", (), {"parts": lambda _: parts})())
        return neutral_curve(image, *told)

    warned = with_check(warning="it is Tuesday")
    assert warned.warnings[1:] == (*without.warnings[1:], "it is Tuesday")
    added = np.sqrt(warned.sigma_m**2 - without.sigma_m**2) * 2000
    assert added == pytest.approx(1.0, rel=1e-6)
    at_end = np.sqrt(warned.end_sigma_m**2 - without.end_sigma_m**2) * 2000
    assert at_end == pytest.approx(30.0, rel=1e-6)
    refused = with_check(refusal="check of the day failed: it is Tuesday.")
    assert not refused.ok
    assert refused.why == "check of the day failed: it is Tuesday."


def test_a_thin_strip_that_is_thinner_further_on_shows_both_edges_there():
    line = arc(150, 0.0, heading_rad=0.0)
    across, share = beside(line)
    thick = np.where(share < 0.5, 4.6, 2.4)
    light = 140.0 * np.clip(thick / 2 - np.abs(across) + 0.5, 0, 1)
    grey = 60 + light + np.random.default_rng(5).normal(0, 2, SIZE)
    image = read_grey_image(np.clip(np.round(grey), 0, 255).astype(np.uint8), stated())
    basis = make_basis(150.0, 150.0, 6, 1.0)
    shape = make_shape(basis, np.zeros(2), 0.0, np.zeros(basis.size))
    blocks = measure_blocks(shape, [image], stated(), 4.6, np.ones(len(shape.x)))
    assert blocks.by_edges.mean() > 0.9


@pytest.mark.thorough
def test_a_strip_of_few_blocks_is_as_long_as_before_where_lonely_ones_are_left_out():
    line = arc(60, 0.0, heading_rad=0.0)
    image = read_grey_image(drawn(line, 24), stated())
    basis = make_basis(60.0, 60.0, 4, 1.0)
    shape = make_shape(basis, np.zeros(2), 0.0, np.zeros(basis.size))
    blocks = measure_blocks(shape, [image], stated(), 24.0, np.ones(len(shape.x)))
    assert len(blocks.seen) < 11  # fewer than the neighbours that are asked
    np.testing.assert_array_equal(without_lonely(blocks).seen, blocks.seen)


@pytest.mark.parametrize("side", [1, -1])
def test_where_a_clamp_has_edges_of_its_own_its_stated_place_counts(side):
    line = arc(150, 0.0, heading_rad=0.0)
    across, share = beside(line)
    image = drawn(line, 12).astype(float)
    jaw = (share < 0.05) & (side * across > 0) & (side * across < 10)
    image[jaw] = 200.0  # it looks four pixels thicker there, to one side
    image = read_grey_image(image.astype(np.uint8), stated())
    basis = make_basis(150.0, 150.0, 8, 1.0)
    shape = make_shape(basis, np.zeros(2), 0.0, np.zeros(basis.size))
    places = StatedPlaces.of(stated(clamp_sigma_px=3.0), 12.0)
    fit, without = (
        fit_outline(
            shape,
            [image],
            stated(),
            width_px=12.0,
            prior=np.array([6.0, 0.4]),
            work=OutlineWork(),
            places=each,
        )
        for each in (places, None)
    )
    assert abs(without.shape.y[0]) > 0.8
    assert abs(fit.shape.y[0]) < 0.7 * abs(without.shape.y[0])
    assert np.abs(fit.shape.y[40:]).max() < 0.3


def test_a_line_thinner_than_a_pixel_has_a_thickness():
    line = arc(150, 0.4)
    optics, strip = of_length(150, thickness_m=0.003)
    image = read_grey_image(drawn(line, 1.0, noise=0.5), optics)
    assert visible_thickness_m(image, optics, strip) * 2000 >= 1.0

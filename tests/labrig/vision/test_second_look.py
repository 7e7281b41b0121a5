"""A second look by what stands out: when it counts, and what becomes of the curve."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from labrig.vision import NeutralCurve, Optics, StripGeometry
from labrig.vision.checks.kinds.strip_goes_on import CHECK as STRIP_GOES_ON
from labrig.vision.extraction import extract
from labrig.vision.extraction.outline_report import ASSUMED
from labrig.vision.extraction.salience import network, second_look
from labrig.vision.extraction.salience.merging import GOES_ON
from labrig.vision.extraction.salience.middle_line import distances, lengths
from tests.labrig.vision.salient_strips import CLAMP, SIZE, arc, strip_map

PICTURE = np.zeros((*SIZE, 3), dtype=np.uint8)
OPTICS = Optics(
    px_per_mm=4.0, clamp_px=tuple(CLAMP), image_size=SIZE[::-1], clamp_angle_known=True,
    clamp_sigma_px=3.0,
)  # fmt: skip
STRIP = StripGeometry(free_length_m=0.04, length_known=False, thickness_known=False)
REFUSED = NeutralCurve(ok=False, why="search failed: only 40% of the best path shows two edges.")


def curve_along(path: np.ndarray, sigma_px: float = 0.3) -> NeutralCurve:
    """Return a curve as the edges give one, along a path in pixels."""
    plane = OPTICS.pixel_to_world(path)
    return NeutralCurve(
        ok=True, s_m=lengths(plane), x_m=plane[:, 0], y_m=plane[:, 1], points_px=path,
        sigma_m=np.full(len(path), sigma_px / OPTICS.px_per_m), end_sigma_m=1e-4,
        thickness_m=12 / OPTICS.px_per_m, contrast=50.0, warnings=("as before",),
        seen=np.ones(len(path), dtype=bool), covered=1.0,
    )  # fmt: skip


@pytest.fixture
def shows(monkeypatch):
    """Let the picture show a map, whichever part of it is looked at."""

    def show(salience: np.ndarray, turned_over: np.ndarray | None = None) -> None:
        other = salience if turned_over is None else turned_over

        def look(part):
            return other[:, ::-1] if part[0, 0, 0] else salience

        monkeypatch.setattr(second_look, "salience", look)
        monkeypatch.setattr(second_look, "NEARER_MAX", 0.0)  # so the second look is turned over

    picture = PICTURE.copy()
    picture[:, -1] = 1  # the first column when it is turned over

    def looked(first: NeutralCurve, optics: Optics = OPTICS, strip: StripGeometry = STRIP):
        return second_look.seen_again(first, picture, optics, strip)

    show.then = looked
    return show


def test_a_curve_that_ends_early_is_led_on_to_the_tip(shows):
    shows(strip_map(arc()))
    found = shows.then(curve_along(arc()[:200]))
    assert found.ok
    assert np.hypot(*(found.points_px[-1] - arc()[-1])) < 1.5
    assert distances(arc(), found.points_px).max() < 1.5
    seen_by_edges, led_on = (found.sigma_m[round(at * len(found.s_m))] for at in (0.3, 0.75))
    assert led_on > seen_by_edges  # what stands out is coarser
    assert found.warnings[0] == "as before"
    assert "thickness 3.00 mm, length 39.8 mm" in found.warnings[1]
    assert "led on" in found.warnings[2]
    assert found.curvature_per_m[len(found.s_m) // 2] == pytest.approx(
        OPTICS.px_per_m * 1.2 / 160 * (-1 if found.y_m[-1] < 0 else 1), rel=0.3
    )


def bridged(curve: NeutralCurve, begin: int, end: int) -> NeutralCurve:
    """Return a curve whose edges are hidden from one place to another, and known to 2 pixels."""
    hidden = (np.arange(len(curve.s_m)) >= begin) & (np.arange(len(curve.s_m)) < end)
    sigma_m = np.where(hidden, 2.0 / OPTICS.px_per_m, curve.sigma_m)
    return replace(curve, seen=~hidden, sigma_m=sigma_m, covered=float((~hidden).mean()))


@pytest.mark.parametrize("places", [400, 320])  # the other ends early, and is led on
def test_what_was_hidden_stays_so_and_keeps_its_sigma(shows, places):
    shows(strip_map(arc()))
    found = shows.then(bridged(curve_along(arc()[:places]), 120, 180))
    along_px = lengths(found.points_px)
    hidden = (along_px > 50) & (along_px < 70)
    assert not found.seen[hidden].any()
    assert found.sigma_m[hidden].min() * OPTICS.px_per_m == pytest.approx(2.0, abs=0.1)
    beside = (along_px < 46) | (along_px > 74)
    assert found.seen[beside].all()
    assert found.sigma_m[(along_px > 20) & (along_px < 46)].max() * OPTICS.px_per_m < 1.0
    assert found.covered == found.seen.mean() < 0.9


def test_a_bridge_that_leads_away_from_what_stands_out_is_none_of_it(shows):
    shows(strip_map(arc()))
    found = shows.then(bridged(curve_along(arc()[:300]), 255, 280))  # it had left the strip there
    assert any("led on" in text for text in found.warnings)
    assert found.seen.all()


def test_where_the_strip_stands_out_in_pieces_none_of_them_shows_its_end(shows):
    first = bridged(curve_along(arc()), 170, 220)
    piece = strip_map(arc()[:170])
    shows(np.maximum(piece, strip_map(arc()[220:])))
    assert shows.then(first) is first
    for further_on in (np.zeros(SIZE), strip_map(arc()[220:280])):  # nothing, or no strip
        shows(np.maximum(piece, further_on))
        assert any("ceases to stand out" in text for text in shows.then(first).warnings)


def test_what_stands_out_settles_a_doubt_and_a_look_that_shows_nothing_does_not(shows):
    doubted = replace(curve_along(arc()[:200]), doubt="it ends elsewhere.")
    shows(strip_map(arc()))
    assert shows.then(doubted).confirmed().ok
    shows(np.zeros(SIZE))
    assert shows.then(doubted).confirmed().why == "it ends elsewhere."


def test_what_was_said_of_the_end_that_is_no_longer_so_is_left_out(shows):
    assert STRIP_GOES_ON.warning.startswith(GOES_ON)
    shows(strip_map(arc()))
    said = (STRIP_GOES_ON.warning.format(u=1, v=2), f"{ASSUMED}length 20.0 mm", "in colour")
    found = shows.then(replace(curve_along(arc()[:200]), warnings=said))
    assert found.warnings[0] == "in colour"
    assert not any(text.startswith(GOES_ON) or "20.0" in text for text in found.warnings)


def test_a_curve_that_goes_on_is_cut_and_its_end_holds_both(shows):
    shows(strip_map(arc()[:300]))
    found = shows.then(curve_along(arc()))
    assert lengths(found.points_px)[-1] == pytest.approx(120, abs=2)
    assert found.end_sigma_m * OPTICS.px_per_m == pytest.approx(40, abs=4)
    assert "ceases to stand out" in found.warnings[2]


def test_where_both_end_alike_the_better_known_one_weighs_more(shows):
    shows(strip_map(arc()))
    aside = arc() + np.array([0.0, 0.8])
    good, poor = (shows.then(curve_along(aside, sigma_px)) for sigma_px in (0.1, 2.0))
    middle = slice(40, 120)  # of some 160 points
    assert distances(good.points_px[middle], aside).max() < 0.3
    assert distances(poor.points_px[middle], arc()).max() < 0.4
    assert [text[:9] for text in good.warnings] == ["as before", "measured "]


@pytest.mark.parametrize(
    "first",
    [
        curve_along(arc(turn=-0.5)),  # another course
        replace(curve_along(arc()), thickness_m=5 / OPTICS.px_per_m),  # another width
        curve_along(arc(length=400, turn=0.0)[:258]),  # to the border
    ],
)
def test_a_curve_of_something_else_stays_as_it_is(shows, first):
    shows(strip_map(arc()))
    assert shows.then(first) is first


def test_where_the_edges_gave_no_curve_nothing_is_looked_at(shows):
    shows(strip_map(arc()))
    assert shows.then(REFUSED) is REFUSED


def test_two_looks_that_disagree_do_not_count(shows):
    first = curve_along(arc()[:200])
    shows(strip_map(arc()), strip_map(arc()[:250]))
    assert shows.then(first) is first
    shows(strip_map(arc(), 40.0))  # no strip by its shape
    assert shows.then(first) is first


def test_nothing_is_looked_at_where_enough_is_stated_or_the_strip_is_thin(shows):
    shows(strip_map(arc()))
    first = curve_along(arc()[:200])
    assert shows.then(first) is not first
    assert shows.then(first, strip=replace(STRIP, length_known=True)) is first
    assert shows.then(first, OPTICS.model_copy(update={"tip_px": (200.0, 150.0)})) is first
    thin = replace(first, thickness_m=2 / OPTICS.px_per_m)
    assert shows.then(thin) is thin


def test_a_curve_that_is_followed_is_looked_at_where_the_one_before_was_changed_by_that(
    shows, monkeypatch
):
    shows(strip_map(arc()))
    first = curve_along(arc()[:200])
    led_on = shows.then(first)
    monkeypatch.setattr(extract, "unconfirmed_curve", lambda *_, start: first)
    monkeypatch.setattr(extract, "seen_again", lambda *_: led_on)

    def found(start):
        return extract.neutral_curve(PICTURE, OPTICS, STRIP, start=start)

    assert found(None) == led_on.confirmed()
    assert found(REFUSED) == led_on.confirmed()
    assert found(led_on) == led_on.confirmed()
    assert found(first) == first.confirmed()


@pytest.mark.parametrize("shape", [SIZE, (*SIZE, 1), (*SIZE, 3), (*SIZE, 4)])
@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32])
def test_the_network_is_shown_three_colours_of_every_kind_of_image(monkeypatch, shape, kind):
    shown = []

    class Network:
        def setInput(self, colours):
            shown.append(colours)

        def forward(self, output):
            return np.zeros((1, 1, network.SIDE_PX, network.SIDE_PX), np.float32)

    monkeypatch.setattr(network, "_network", Network)
    image = np.full(shape, 1, dtype=kind)
    assert network.salience(image).shape == SIZE
    white = (1 - np.array(network.MEAN)) / network.SPREAD
    assert shown[0].shape == (1, 3, network.SIDE_PX, network.SIDE_PX)
    assert np.allclose(shown[0], white[None, :, None, None])


def test_the_network_shows_a_strip_on_plain_ground():
    picture = np.full((*SIZE, 3), 230, dtype=np.uint8)
    inside = strip_map(arc(), 14.0) > 0.5
    picture[inside] = (40, 60, 140)
    shown = network.salience(cv2.GaussianBlur(picture, (0, 0), 1.0))
    assert shown.shape == SIZE
    assert (shown[inside] > 0.5).mean() > 0.9
    assert (shown[~inside] > 0.5).mean() < 0.05

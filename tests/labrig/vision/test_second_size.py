"""A curve of a strip of which little is stated must be the same in a smaller picture."""

import numpy as np
import pytest

from labrig.vision import Optics, StripGeometry, neutral_curve
from labrig.vision.curve import NeutralCurve
from labrig.vision.extraction import outline_curve, second_size
from labrig.vision.extraction.extract import unconfirmed_curve
from tests.cases import few
from tests.labrig.vision.drawn_strips import BENT_UP, STRIP, off_px

WAY = np.stack([np.linspace(10, 210, 201), np.full(201, 50.0)], axis=1)
STATED = BENT_UP.optics
TO_END = StripGeometry(free_length_m=STRIP.free_length_m, length_known=False, thickness_known=False)


def bent_aside(most_px):
    share = np.linspace(0, 1, len(WAY))
    return WAY + np.stack([np.zeros(len(WAY)), most_px * np.sin(np.pi * share)], axis=1)


def searches(monkeypatch, *results):
    """The searches that are done, in turn with these results in place of their own."""
    done, real, left = [], second_size.searched_outline, list(results)

    def search(images, optics, strip):
        done.append(images[0].grey.shape)
        found = real(images, optics, strip)
        return left.pop(0)(found) if left else found

    monkeypatch.setattr(second_size, "searched_outline", search)
    return done


def as_it_is(found):
    return found


def refused_for(why):
    return lambda _: NeutralCurve(ok=False, why=why)


@pytest.mark.parametrize("other", [WAY, WAY[:-6], WAY[:-3] + 0.8, bent_aside(3.5)])
def test_paths_that_differ_by_a_few_pixels_agree(other):
    assert second_size.apart(WAY, other) == ""


@pytest.mark.parametrize("other", [WAY[:-12], WAY[:100]])
def test_an_end_elsewhere_is_named_with_both_places(other):
    said = second_size.apart(WAY, other)
    assert said.startswith("check of the end failed")
    assert "210,50" in said
    assert f"{other[-1, 0]:.0f},50" in said


def test_another_way_is_named_with_how_far_it_lies_aside():
    said = second_size.apart(WAY, bent_aside(30.0))
    assert said.startswith("check of the course failed")
    assert "30 pixels" in said


@pytest.mark.slow
def test_a_plain_strip_is_the_same_at_both_sizes(monkeypatch):
    done = searches(monkeypatch)
    found = neutral_curve(BENT_UP.image, STATED, TO_END)
    assert found.ok, found.why
    rows, columns = BENT_UP.image.shape
    assert done == [(rows, columns), (int(0.7 * rows), int(0.7 * columns))]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("why", "refused"),
    few(
        [
            (outline_curve.TWO_WAYS, True),
            ("check of the width failed: it changes.", True),
            (outline_curve.UNSEEN, False),
            (second_size.START_UNSEEN, False),
        ]
    ),
)
def test_what_is_only_not_seen_in_fewer_pixels_contradicts_nothing(monkeypatch, why, refused):
    searches(monkeypatch, as_it_is, refused_for(why))
    found = neutral_curve(BENT_UP.image, STATED, TO_END)
    assert found.ok != refused
    assert not refused or found.why.endswith(why)


@pytest.mark.thorough
@pytest.mark.slow
def test_another_look_gets_the_curve_with_the_doubt(monkeypatch):
    searches(monkeypatch, as_it_is, refused_for(outline_curve.TWO_WAYS))
    doubted = unconfirmed_curve(BENT_UP.image, STATED, TO_END)
    assert doubted.ok
    assert off_px(doubted.points_px, BENT_UP) < 0.3
    assert doubted.doubt.endswith(outline_curve.TWO_WAYS)


RIVAL = second_size.RIVAL_STEP + ": there is another one."


@pytest.mark.slow
def test_a_strip_with_a_second_edge_is_taken_from_two_smaller_pictures(monkeypatch):
    done = searches(monkeypatch, refused_for(RIVAL))
    found = neutral_curve(BENT_UP.image, STATED, TO_END)
    assert found.ok
    assert second_size.MADE_SMALLER in found.warnings
    assert len(done) == 3
    assert off_px(found.points_px, BENT_UP) < 0.3


@pytest.mark.slow
@pytest.mark.parametrize("not_shown", few([1, 2]))
def test_it_stays_refused_where_one_of_them_does_not_show_it(monkeypatch, not_shown):
    shown = [as_it_is] * (not_shown - 1)
    searches(monkeypatch, refused_for(RIVAL), *shown, refused_for(outline_curve.UNSEEN))
    assert neutral_curve(BENT_UP.image, STATED, TO_END).why == RIVAL


@pytest.mark.slow
def test_what_is_refused_otherwise_is_searched_once(monkeypatch):
    done = searches(monkeypatch, refused_for(outline_curve.TWO_WAYS))
    assert neutral_curve(BENT_UP.image, STATED, TO_END).why == outline_curve.TWO_WAYS
    assert len(done) == 1


@pytest.mark.slow
@pytest.mark.parametrize("stated", few(["length", "tip"]))
def test_a_strip_whose_end_is_stated_is_looked_at_once(monkeypatch, stated):
    done = searches(monkeypatch)
    optics, strip = STATED, TO_END
    if stated == "tip":
        end = neutral_curve(BENT_UP.image, STATED, TO_END).points_px[-1]
        optics = Optics.from_json(STATED.to_json()).model_copy(update={"tip_px": tuple(end)})
        done.clear()
    else:
        strip = StripGeometry(free_length_m=STRIP.free_length_m, thickness_known=False)
    assert neutral_curve(BENT_UP.image, optics, strip).ok
    assert len(done) == 1


@pytest.mark.thorough
@pytest.mark.slow
def test_a_curve_that_is_followed_is_looked_at_once(monkeypatch):
    start = neutral_curve(BENT_UP.image, STATED, TO_END)
    done = searches(monkeypatch)
    assert neutral_curve(BENT_UP.image, STATED, TO_END, start=start).ok
    assert done == []

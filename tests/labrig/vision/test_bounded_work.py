"""However much in an image looks like a strip, a refusal does no more than is stated."""

import numpy as np
import pytest

from labrig.vision import Optics, StripGeometry, neutral_curve
from labrig.vision.checks.contract import CurveFinding
from labrig.vision.extraction import likeliest_paths, outline_curve
from labrig.vision.fit import outline
from labrig.vision.search import locate, located, path_search, work
from labrig.vision.search.beam_paths import BEAM_STATES, ROUGH_STATES
from labrig.vision.thresholds import OUTLINE_BROAD_MAX, OUTLINE_ROUGH_MAX, OUTLINE_ROUNDS_MAX

CHANNELS = 3
ROWS, COLUMNS = 160, 200
OPTICS = Optics(px_per_mm=2.0, clamp_px=(30.0, 80.0), clamp_angle_known=False)
UNKNOWN = StripGeometry(free_length_m=0.05, length_known=False, thickness_known=False)


def hard_picture():
    """Waves in all directions, other ones in each colour: paths lead everywhere."""
    random = np.random.default_rng(3)
    v, u = np.indices((ROWS, COLUMNS))
    channels = []
    for _ in range(CHANNELS):
        grey = np.full((ROWS, COLUMNS), 128.0)
        for _ in range(12):
            turn, period = random.uniform(0, np.pi), random.uniform(9, 60)
            along = u * np.cos(turn) + v * np.sin(turn) + 9 * np.sin(v / 23 + turn)
            grey += 22 * np.sin(2 * np.pi * along / period + random.uniform(0, 6))
        channels.append(grey)
    return np.clip(np.stack(channels, axis=2), 0, 255).astype(np.uint8)


@pytest.fixture
def counted(monkeypatch):
    """Count what is really called, whatever the budget says."""
    calls = {ROUGH_STATES: 0, BEAM_STATES: 0, "rounds": 0, "fits": 0}

    def counting(module, name, what):
        real = getattr(module, name)

        def call(*args, **kwargs):
            calls[what or kwargs["width"]] += 1
            return real(*args, **kwargs)

        monkeypatch.setattr(module, name, call)

    counting(path_search, "search", None)
    counting(outline, "measure_blocks", "rounds")
    counting(outline_curve, "fitted_outline", "fits")
    return calls


@pytest.mark.slow
def test_a_picture_full_of_paths_takes_no_more_searches_and_rounds_than_stated(counted):
    found = neutral_curve(hard_picture(), OPTICS, UNKNOWN)
    assert not found.ok
    assert counted[ROUGH_STATES] > 2 * CHANNELS * 4  # it is hard: several widths, more than once
    assert counted[ROUGH_STATES] <= CHANNELS * OUTLINE_ROUGH_MAX
    assert 0 < counted[BEAM_STATES] <= 2 * OUTLINE_BROAD_MAX  # the further half by itself
    assert 0 < counted["rounds"] <= OUTLINE_ROUNDS_MAX
    assert counted["fits"] <= likeliest_paths.FITTED_MAX


@pytest.mark.slow
def test_nothing_is_fitted_beyond_the_bound_and_the_sentence_says_what_would_help(
    counted, monkeypatch
):
    monkeypatch.setattr(work, "OUTLINE_ROUGH_MAX", 9)
    monkeypatch.setattr(work, "OUTLINE_BROAD_MAX", 2)
    monkeypatch.setattr(work, "OUTLINE_ROUNDS_MAX", 1)
    found = neutral_curve(hard_picture(), OPTICS, UNKNOWN)
    assert found.why == outline_curve.TOO_MUCH
    assert counted[ROUGH_STATES] <= CHANNELS * 9
    assert counted[BEAM_STATES] <= 2 * 2
    assert counted["rounds"] == 1


@pytest.mark.thorough
def test_a_path_beside_a_curve_that_was_refused_is_not_fitted_again(counted, monkeypatch):
    picture = np.full((ROWS, COLUMNS, 3), 60, np.uint8)
    picture[77:84, 30:170] = (40, 120, 200)  # it shows in all channels
    found = []
    real = outline_curve.likeliest_first
    monkeypatch.setattr(
        outline_curve, "likeliest_first", lambda *known: found.extend(real(*known)) or found
    )
    monkeypatch.setattr(outline_curve, "outline_fault", lambda *_: CurveFinding(refusal="refused"))
    assert neutral_curve(picture, OPTICS, UNKNOWN).why == "refused"
    assert len(found) > 1
    assert counted["fits"] == 1


@pytest.mark.slow
@pytest.mark.usefixtures("one_look")
def test_a_path_that_could_not_be_comparable_is_not_measured(monkeypatch):
    picture = np.full((ROWS, COLUMNS), 40, np.uint8)
    picture[78:83, 30:170] = 200
    picture[92:97, 30:170] = 200  # begins elsewhere
    measured = []
    real = locate.measured_along

    def one(image, path, *rest, **known):
        if image.grey.shape == picture.shape:  # it is made smaller later
            measured.append(located.aside_px(path, OPTICS.clamp_px))
        return real(image, path, *rest, **known)

    monkeypatch.setattr(locate, "measured_along", one)
    assert neutral_curve(picture, OPTICS, UNKNOWN).ok
    assert max(measured) < 3 * located.ASIDE_USUAL_PX

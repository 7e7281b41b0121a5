"""A gap that the noise of curves would swallow is told as something unknown in the pictures."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy.criticism.image_noise import aside, image_noise, unusual_images
from model.discrepancy.thresholds import EVIDENCE_THRESHOLD_LN
from model.measurements import Condition, Curve, Measurements
from tests.cases import few
from tests.model.discrepancy.sessions import NOTHING, base_fit, diagnosed, fitted, session

TURN_RAD = 1.5e-3


def turned(m: Measurements, which: Collection[str], size_rad: float = TURN_RAD) -> Measurements:
    """Every picture of these configurations turned about the clamp by an angle of its own."""
    random = np.random.default_rng(5)

    def one(condition: Condition) -> Condition:
        angle = size_rad * float(random.standard_normal())
        if condition.configuration not in which:
            return condition
        readings = tuple(replace(r, curve=_turned(r.curve, angle)) for r in condition.readings)
        return replace(condition, readings=readings, curve=_turned(condition.curve, angle))

    return replace(m, conditions=tuple(map(one, m.conditions)))


def _turned(curve: Curve | None, angle: float) -> Curve | None:
    if curve is None:
        return None
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = cos * curve.x_m - sin * curve.y_m, sin * curve.x_m + cos * curve.y_m
    return replace(curve, x_m=x, y_m=y)


@pytest.mark.slow
def test_usual_noise_of_curves_is_no_evidence():
    found = image_noise(base_fit(NOTHING))
    assert set(found) == {"long", "short"}
    assert all(one.evidence < 0.3 * EVIDENCE_THRESHOLD_LN for one in found.values())
    assert not unusual_images(base_fit(NOTHING))


@pytest.mark.slow
@pytest.mark.parametrize("which", few(["long", "short"]))
def test_noise_of_one_configuration_is_compared_with_the_other(which):
    found = unusual_images(fitted(turned(session(NOTHING), {which})))
    assert found[0].score.candidate.part.endswith(which)
    assert found[0].ln_bayes_factor > 5.0 * EVIDENCE_THRESHOLD_LN
    # at the same noise other locations explain less
    assert found[1].ln_bayes_factor < found[0].ln_bayes_factor - EVIDENCE_THRESHOLD_LN


@pytest.mark.slow
def test_noise_that_all_configurations_have_is_the_cameras_usual_one():
    """Images of one condition may have in common what they do not show by themselves."""
    assert not unusual_images(fitted(turned(session(NOTHING), {"long", "short"})))


@pytest.mark.thorough
@pytest.mark.slow
def test_few_pictures_that_are_far_off_are_outliers():
    m = session(NOTHING)
    own = [i for i, c in enumerate(m.conditions) if c.configuration == "short"]
    wrong = turned(replace(m, conditions=tuple(m.conditions[i] for i in own[3:9:3])), {"short"})
    conditions = list(m.conditions)
    for i, one in zip(own[3:9:3], wrong.conditions, strict=True):
        conditions[i] = one
    found = fitted(replace(m, conditions=tuple(conditions)))
    assert image_noise(found)["short"].evidence > EVIDENCE_THRESHOLD_LN
    assert not unusual_images(found)


@pytest.mark.slow
def test_a_single_configuration_has_nothing_to_be_compared_with():
    m = turned(session(NOTHING), {"short"})
    alone = replace(
        m, sheets={"short": m.sheets["short"]},
        conditions=tuple(c for c in m.conditions if c.configuration == "short"),
        series=tuple(s for s in m.series if s.configuration == "short"),
    )  # fmt: skip
    assert not unusual_images(fitted(alone))


def test_the_picture_that_is_farthest_off_is_named_with_its_session():
    """A made scene of three pictures, the last of which is shifted most."""
    s = np.linspace(0.0, 0.05, 4)
    for sessions, name in ((1, "short, 2 mm, +1 V"), (2, "short, 2 mm, +1 V, session 2")):
        seen = [
            SimpleNamespace(name=f"short, {k} mm, +1 V", session=min(1 + k // 2, sessions))
            for k in range(3)
        ]
        configuration_model = SimpleNamespace(
            data_vector=SimpleNamespace(seen=seen), sheet=session().sheets["short"],
            has_curve=np.ones(3, dtype=bool), modes=2,
            curve_s=np.tile(s, (3, 1)), along=lambda _, m: m[0] * np.ones(4) + m[1] * s,
        )  # fmt: skip
        found = aside(
            configuration_model, np.array([1.0, 0.0, 0.5, 0.0, -2.0, 0.0]), 0.01 * np.eye(6)
        )
        assert found.name == name
        assert found.off_m == pytest.approx(-2e-4 * np.ones(4))
        assert found.sigma_m == pytest.approx(1e-5 * np.hypot(1.0, s))


@pytest.mark.slow
def test_a_gap_in_the_pictures_of_one_sheet_is_reported_as_unknown():
    from model.discrepancy import diagnose
    from tests.fits_unchecked import fits_unchecked

    with fits_unchecked():
        found = diagnose(turned(session(NOTHING), {"short"}))
    assert found.verdict == "unknown_effect"
    assert found.effects == ()
    assert found.unknown is not None
    assert (found.unknown.location, found.unknown.configuration) == ("camera", "short")
    assert np.max(np.abs(found.unknown.profile)) > 0.05  # mm, at the end of the sheet
    assert "each picture of 'short' the curve is shifted and turned" in found.sentence
    assert "times the usual standard deviation, and most in that of short, " in found.sentence
    assert found.sentence.endswith("do clamp and camera stand still?")
    assert found.ranking[0].name == "unknown:camera"
    assert found.ranking[0].log_bayes > EVIDENCE_THRESHOLD_LN
    assert found.ranking[0].why_not == "reported, at the usual noise of curves"
    assert not found.model.effects  # no other picture can be predicted with it
    assert diagnosed(NOTHING).verdict == "nothing_missing"

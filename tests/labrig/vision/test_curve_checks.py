"""The table of checks: each conforms, and one more is one file that nothing else knows of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from drivers.plugins import Part
from labrig.testing import curve_check_faults
from labrig.vision import neutral_curve
from labrig.vision.checks import catalogue
from labrig.vision.checks.catalogue import curve_checks
from labrig.vision.checks.conformance import faults
from labrig.vision.checks.contract import CheckStage, CurveCheck, CurveFinding

PAGE = Path(__file__).parents[3] / "docs" / "howto" / "extending.md"


class Always(CurveCheck):
    """A check that says the same of every curve."""

    def finding(self, seen):
        """See `CurveCheck.finding`."""
        if self.name == "broken":
            raise KeyError("no such thing")
        if self.name == "wordy":
            return "bad"
        if self.name == "short":
            return CurveFinding(warning="never said", widening_px=np.ones(3))
        if self.name == "endless":
            return CurveFinding(warning="never said", end_widening_px=np.nan)
        if self.name == "mute":
            return CurveFinding()
        if self.name == "forgetful":
            return self.refuse()
        if self.name == "misspelt":
            return self.warn(widening_px=None, wide_px=3.0)
        if self.name == "writing":
            seen.image.grey[:] = 0
            return None
        if self.name == "imaged" and seen.image.grey.shape != seen.context.image.grey.shape:
            return self.warn()
        if self.name == "imaged":
            return None
        if self.name == "nowhere":
            return CurveFinding(refusal="Never said.", refused_at_px=(np.nan, 3.0))
        wide = np.full(len(seen.fit.shape.x), 1.0)
        return CurveFinding(refusal=self.refusal, warning=self.warning, widening_px=wide)


@pytest.fixture
def with_check(monkeypatch):
    """Add a check of another distribution."""

    def add(name, stage, **said):
        check = Always(name=name, looks_at="nothing", stage=stage, order=1, **said)
        parts = catalogue.FOLDER.parts() | {name: Part(name, check, "labrig-extra", "0.1")}
        folder = type("Folder", (), {"parts": lambda _: parts})()
        monkeypatch.setattr(catalogue, "FOLDER", folder)

    return add


@pytest.mark.parametrize("name", curve_checks())
def test_each_check_of_a_curve_conforms(name):
    assert faults(curve_checks()[name]) == []
    assert curve_checks()[name].name == name


def test_orders_differ_so_that_the_first_refusal_is_always_the_same():
    orders = [check.order for check in curve_checks().values()]
    assert len(set(orders)) == len(orders)
    assert orders == sorted(orders)


@pytest.mark.slow
def test_the_check_on_the_page_about_extending_conforms():
    section = PAGE.read_text(encoding="utf-8").split("## A curve check")[1]
    there: dict[str, object] = {"__name__": "example"}
    exec(compile(section.split("```python")[1].split("```")[0], "extending.md", "exec"), there)
    assert curve_check_faults(there["CHECK"]) == []


def test_a_faulty_check_is_told_what_is_wrong():
    assert faults("check") == ["it is of type str, not a CurveCheck"]
    silent = CurveCheck(name="a check", looks_at="", order=1)
    assert len(faults(silent)) == 4
    wordy = Always(name="x", looks_at="it", refusal="No.", warning="Hm.", order=1)
    assert [("refusal" in each, "warning" in each) for each in faults(wordy)] == [
        (True, False),
        (False, True),
    ]


def test_the_page_of_checks_has_each_with_its_sentence():
    page = _page()
    for check in curve_checks().values():
        assert f"| `{check.name}` | {check.stage} | {check.looks_at} |" in page
        assert check.refusal in page
        assert check.warning in page


def _page():
    path = PAGE.parents[1] / "made" / "curve_checks.py"
    there: dict[str, object] = {"__name__": "made"}
    exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), there)
    return there["page"]()


@pytest.mark.slow
@pytest.mark.parametrize("stage", [CheckStage.CHOSEN, CheckStage.UNCERTAINTY])
def test_a_check_of_another_distribution_warns_and_widens(plain, known, with_check, stage):
    without = neutral_curve(plain.image, *known(plain))
    with_check("extra", stage, warning="it is Tuesday")
    curve = neutral_curve(plain.image, *known(plain))
    assert curve.warnings == (*without.warnings, "it is Tuesday")
    optics = known(plain)[0]
    added = np.sqrt(curve.sigma_m**2 - without.sigma_m**2) * optics.px_per_m
    assert added == pytest.approx(1.0, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("stage", [CheckStage.CHOSEN, CheckStage.UNCERTAINTY])
def test_a_check_of_another_distribution_refuses(plain, known, with_check, stage):
    with_check("extra", stage, refusal="check of the day failed: it is Tuesday.")
    curve = neutral_curve(plain.image, *known(plain))
    assert not curve.ok
    assert curve.why == "check of the day failed: it is Tuesday."


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["broken", "wordy", "short", "nowhere", "endless", "mute", "forgetful"]
)
def test_a_check_of_another_distribution_that_fails_costs_no_curve(plain, known, with_check, name):
    with_check(name, CheckStage.CHOSEN, warning="never said")
    curve = neutral_curve(plain.image, *known(plain))
    assert curve.ok
    assert [w for w in curve.warnings if f"'{name}' of labrig-extra 0.1 failed" in w]


@pytest.mark.slow
@pytest.mark.parametrize("stage", [CheckStage.CANDIDATE, CheckStage.UNCERTAINTY])
def test_a_check_of_another_distribution_cannot_spoil_the_image(plain, known, with_check, stage):
    without = neutral_curve(plain.image, *known(plain))
    with_check("writing", stage, warning="never said")
    curve = neutral_curve(plain.image, *known(plain))
    assert curve.ok
    assert np.array_equal(curve.y_m, without.y_m)
    assert any("'writing' of labrig-extra 0.1 failed" in warning for warning in curve.warnings)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("broken", "its code raised KeyError: 'no such thing' (test_curve_checks.py, line "),
        ("wordy", "it returned str, not a CurveFinding"),
        ("short", "widening_px must be 121 finite numbers, one for each node"),
        ("endless", "end_widening_px must be a number of pixels, 0 or more"),
        ("mute", "its CurveFinding has neither a refusal nor a warning nor a widening"),
        ("forgetful", "its refusal is empty, so nothing can be said with it"),
        ("writing", "it changes seen.image.grey, which must stay as it is; work on a copy"),
        ("misspelt", "its warning has a place for 'beside_px', which is given no value"),
    ],
)
def test_a_check_is_asked_about_drawn_strips_before_anybody_uses_it(name, said):
    check = Always(name=name, looks_at="it", warning="{beside_px} beside", order=1)
    (fault,) = curve_check_faults(check)
    assert fault.startswith("asked about a drawn strip (SeenCurve), ")
    assert said in fault


@pytest.mark.slow
@pytest.mark.parametrize("stage", CheckStage)
def test_a_check_finds_the_image_of_curves_and_outlines_under_one_name(stage):
    check = Always(name="imaged", looks_at="it", warning="it", stage=stage, order=1)
    assert curve_check_faults(check) == []


class OfCurves(CurveCheck):
    """A check that knows of no outlines."""

    def finding(self, seen):
        """See `CurveCheck.finding`."""
        return self.warn() if seen.sheet_end is None else None


@pytest.mark.slow
def test_a_check_that_fails_on_outlines_alone_is_found():
    check = OfCurves(name="of_curves", looks_at="it", warning="it", order=1)
    (fault,) = curve_check_faults(check)
    assert fault.startswith("asked about the outline of a drawn strip (SeenOutline), its code ")
    assert "no attribute 'sheet_end'" in fault

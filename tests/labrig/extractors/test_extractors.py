"""Curve extractors: what a good one fulfils, and how another distribution adds one."""

from __future__ import annotations

import json
import re
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from labrig.analysis import analyze
from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.extractors.choice import EXTRACTORS, chosen_extractor
from labrig.extractors.conformance import faults
from labrig.extractors.examples import CLAMP_PX, PX_PER_MM, STRIP, examples
from labrig.session import load_measurements, stored_curve_extractor
from labrig.vision import NeutralCurve, neutral_curve
from protocols import Place, make_schedule
from protocols.kinds.pulse_train import PulseTrain
from tests.labrig.analysis.analysed import record_with, with_pictures

DOCS = Path(__file__).parents[3] / "docs" / "howto" / "curve_extractor.md"
OTHER = '''
from dataclasses import replace
from labrig.vision import neutral_curve

class Shifted:
    """The built-in curve, 0.1 mm higher."""
    summary = "Find the curve as the built-in extractor does, 0.1 mm higher."

    def curve(self, image, optics, strip, *, start=None):
        found = neutral_curve(image, optics, strip)
        if not found.ok:
            return found
        points_px = optics.world_to_pixel(list(zip(found.x_m, found.y_m + 1e-4)))
        return replace(found, y_m=found.y_m + 1e-4, points_px=points_px)

class Broken:
    summary = "Never answer."
    curve = None

SHIFTED, BROKEN = Shifted(), Broken()
'''


class Altered:
    """The built-in extractor with something wrong."""

    summary = "Find the curve, but wrongly."

    def __init__(self, alter):
        self.alter = alter

    def curve(self, image, optics, strip, *, start=None):
        return self.alter(neutral_curve(image, optics, strip, start=start), image)


@pytest.fixture
def other(tmp_path, monkeypatch):
    """Another distribution with a good extractor and a broken one."""
    (tmp_path / "other_extractors.py").write_text(OTHER)
    info = tmp_path / "other_extractors-2.1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: other-extractors\nVersion: 2.1\n")
    (info / "entry_points.txt").write_text(
        "[labrig.extractors]\nshifted = other_extractors:SHIFTED\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    yield info
    sys.modules.pop("other_extractors", None)


@pytest.fixture
def documented(tmp_path, monkeypatch):
    """The extractor that the docs describe, installed as the distribution described there."""
    text = DOCS.read_text(encoding="utf-8")
    code = re.findall(r"```python\n(.*?)```", text, re.DOTALL)[-1]
    points = tomllib.loads(re.findall(r"```toml\n(.*?)```", text, re.DOTALL)[-1])
    ((name, where),) = points["project"]["entry-points"]["labrig.extractors"].items()
    (tmp_path / f"{where.partition(':')[0]}.py").write_text(code)
    info = tmp_path / "labrig_column_means-0.1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: labrig-column-means\nVersion: 0.1\n"
    )
    (info / "entry_points.txt").write_text(f"[labrig.extractors]\n{name} = {where}\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield name
    sys.modules.pop(where.partition(":")[0], None)


@pytest.fixture
def strip_image(tmp_path):
    """One of the example images with its files, and the options that name them."""
    cv2.imwrite(str(tmp_path / "strip.png"), examples()[0].image)
    (tmp_path / "optics.json").write_text(
        json.dumps({"px_per_mm": PX_PER_MM, "clamp_px": CLAMP_PX})
    )
    (tmp_path / "sheet.toml").write_text(
        f"free_length_mm = {1e3 * STRIP.free_length_m}\nthickness_mm = {1e3 * STRIP.thickness_m}\n"
    )
    return tmp_path / "strip.png"


def only_on_sheets(alter):
    return lambda curve, image: alter(curve) if curve.ok else curve


def counted(calls):
    def alter(curve, _image):
        calls.append(curve)
        return replace(curve, y_m=curve.y_m + 1e-6 * len(calls))

    return alter


def overwrite(curve, image):
    image[:] = 0
    return curve


@pytest.mark.slow
def test_every_extractor_of_the_folder_fulfils_the_contract():
    assert {name: faults(part.part) for name, part in EXTRACTORS.parts().items()} == {
        name: [] for name in EXTRACTORS.parts()
    }


@pytest.mark.parametrize(
    ("alter", "fault"),
    [
        (lambda _curve, _image: 1 / 0, "raised ZeroDivisionError"),
        (lambda _curve, _image: [1, 2], "returned list, not a NeutralCurve"),
        (lambda _curve, _image: NeutralCurve(ok=False), "a refusal needs a sentence"),
        (lambda _curve, _image: NeutralCurve(ok=False, why="nothing."), "finds no curve: nothing."),
        (overwrite, "changes the image"),
        (counted([]), "another answer to the same image"),
        (only_on_sheets(lambda c: replace(c, x_m=c.x_m[1:])), "x_m has the shape"),
        (only_on_sheets(lambda c: replace(c, sigma_m=c.sigma_m * 1e6)), "it is a length in m"),
        (only_on_sheets(lambda c: replace(c, sigma_m=c.sigma_m * 0)), "sigma_m must be above 0"),
        (only_on_sheets(lambda c: replace(c, s_m=c.s_m * 1e3)), "the strip at 0.03"),
        (only_on_sheets(lambda c: replace(c, y_m=-c.y_m)), "pixels (RMS) from the strip"),
        (only_on_sheets(lambda c: replace(c, points_px=c.points_px[:, ::-1])), "points_px are up"),
        (
            only_on_sheets(lambda c: replace(c, curvature_per_m=-c.curvature_per_m)),
            "from the strip's (median)",
        ),
    ],
)
def test_what_is_wrong_with_an_extractor_is_said(alter, fault):
    assert fault in "; ".join(faults(Altered(alter)))


@pytest.mark.slow
def test_an_extractor_that_sees_a_strip_everywhere_is_at_fault():
    seen = neutral_curve(examples()[0].image, examples()[0].optics, STRIP)
    part = Altered(lambda curve, _image: curve if curve.ok else seen)
    assert faults(part) == ["an image without a strip: it finds a curve where no strip is"]


def test_what_has_no_summary_and_no_method_is_no_extractor():
    assert len(faults(object())) == 2


def test_an_exception_of_an_extractor_becomes_the_reason_of_one_image():
    failing = replace(chosen_extractor(), extractor=Altered(lambda _curve, _image: 1 / 0))
    found = failing.curve(examples()[0].image, examples()[0].optics, STRIP)
    assert not found.ok
    assert "'intensity_fit' failed with ZeroDivisionError: division by zero." in found.why


def test_an_extractor_that_ends_the_program_is_the_reason_of_one_image():
    failing = replace(chosen_extractor(), extractor=Altered(lambda _curve, _image: sys.exit(4)))
    found = failing.curve(examples()[0].image, examples()[0].optics, STRIP)
    assert not found.ok
    assert "'intensity_fit' failed with SystemExit: 4." in found.why


def test_an_unknown_extractor_is_answered_with_those_there_are(strip_image, capsys):
    with pytest.raises(BadInputError, match="choose one of: intensity_fit"):
        chosen_extractor("intensity")
    assert run(["curves", str(strip_image), "--extractor", "intensity"]) == 2
    assert "did you mean 'intensity_fit'?" in capsys.readouterr().err


@pytest.mark.slow
def test_an_installed_extractor_finds_the_curves_of_images(other, strip_image, capsys):
    tips = []
    for name in ("intensity_fit", "shifted"):
        assert run(["curves", str(strip_image), "--json", "--extractor", name]) == 0
        tips.append(json.loads(capsys.readouterr().out)["y_mm"][-1])
    assert tips[1] - tips[0] == pytest.approx(0.1, abs=1e-6)


def test_the_extractor_of_the_docs_works_as_it_stands_there(documented, strip_image, capsys):
    assert EXTRACTORS.origins() == {documented: "labrig-column-means 0.1"}
    tips = []
    for name in ("intensity_fit", documented):
        assert run(["curves", str(strip_image), "--json", "--extractor", name]) == 0
        tips.append(json.loads(capsys.readouterr().out)["y_mm"][-1])
    assert tips[1] == pytest.approx(tips[0], abs=0.2)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_session_records_which_extractor_made_its_curves(other, tmp_path):
    schedule = make_schedule(
        PulseTrain(zero_readings=2, readings_per_voltage=2), [Place("long", (0.005, 0.01))]
    )
    path = record_with(
        tmp_path / "s.h5",
        schedule,
        with_pictures(lambda voltage_V, _reading: 10 + 5 * voltage_V),
        frame_shape=(260, 360),
    )
    built_in = analyze(path)
    assert stored_curve_extractor(path) == ""
    # in two processes, each of which imports the extractor by its name
    shifted = analyze(path, extractor="shifted", workers=2)
    assert stored_curve_extractor(path) == "shifted (other-extractors 2.1)"
    assert shifted.warnings[0] == (
        "The curves are those of the curve extractor shifted (other-extractors 2.1)."
    )
    assert load_measurements(path).warnings == shifted.warnings
    one, other_one = (m.conditions[0].curve for m in (built_in, shifted))
    assert np.allclose(other_one.y_m - one.y_m, 1e-4)


def test_an_extractor_against_the_contract_is_left_out_with_a_sentence(other):
    (other / "entry_points.txt").write_text(
        "[labrig.extractors]\nbroken = other_extractors:BROKEN\n"
    )
    with pytest.warns(UserWarning, match=r"'broken' of other-extractors .* is left out: it has no"):
        assert "broken" not in EXTRACTORS.parts()

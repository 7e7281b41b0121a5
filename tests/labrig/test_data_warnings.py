"""Fits and reports warn of data that can hardly be right; other tests leave that check out."""

from __future__ import annotations

import json
from dataclasses import replace
from html import unescape

import pytest

import model.discrepancy
from labrig.cli.main import run
from tests.labrig.report_data import measure, session

FOUND: dict[str, object] = {}  # by the checksum of the data
WRONG = "the base model does not fit 'long'"


@pytest.fixture(scope="module")
def unlike(tmp_path_factory):
    """A session of one configuration whose load cell showed 5 mN too much, which no sheet does."""
    measured = measure("long")

    def shifted(condition):
        readings = tuple(replace(r, force_N=r.force_N + 5e-3) for r in condition.readings)
        return replace(condition, readings=readings)

    conditions = tuple(map(shifted, measured.conditions))
    path = tmp_path_factory.mktemp("unlike") / "made.h5"
    return session(path, replace(measured, conditions=conditions))


@pytest.fixture(autouse=True)
def searched_once(monkeypatch):
    """Both tests ask the same data, and the search is what takes long."""
    search = model.discrepancy.check_data

    def check_data(measurements):
        if measurements.checksum not in FOUND:
            FOUND[measurements.checksum] = search(measurements)
        return FOUND[measurements.checksum]

    monkeypatch.setattr(model.discrepancy, "check_data", check_data)


@pytest.mark.slow
def test_a_fit_warns_of_a_load_cell_that_was_unlike(unlike, capsys):
    assert run(["fit", str(unlike), "--json"]) == 0
    captured = capsys.readouterr()
    assert f"check the data: {WRONG}" in " ".join(captured.err.split())
    (one,) = json.loads(captured.out)["data_checks"]
    assert WRONG in one["sentence"]


@pytest.mark.thorough
@pytest.mark.usefixtures("words_only")
def test_a_report_warns_of_them_too(unlike, tmp_path):
    assert run(["report", str(unlike), "-o", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out" / "index.html").read_text(encoding="utf-8")
    assert WRONG in " ".join(unescape(page).split())

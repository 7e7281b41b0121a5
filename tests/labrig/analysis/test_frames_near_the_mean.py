"""Each frame's curve is looked for near the curve of the mean image."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from labrig.analysis.curves import CurveJob, curves_of
from labrig.extractors.choice import BUILT_IN
from labrig.extractors.examples import STRIP, examples
from labrig.vision.extraction.curve_search import CurveSearch


@pytest.mark.slow
def test_frames_near_their_mean_are_not_searched_from_the_start(monkeypatch):
    searched = []
    search = CurveSearch.search
    monkeypatch.setattr(CurveSearch, "search", lambda self: searched.append(1) or search(self))
    example = examples()[0]
    planned = SimpleNamespace(configuration="long", position_m=0.01)
    run = SimpleNamespace(planned=planned, image=lambda _row: example.image)
    session = SimpleNamespace(run=lambda _index: run, frame_dtype=str(example.image.dtype))
    job = CurveJob(
        run=0, voltage_V=2.0, rows={0: 0, 1: 1, 2: 2}, in_mean=(0, 1, 2),
        strip=STRIP, optics=example.optics, arc=None, extractor=BUILT_IN,
    )  # fmt: skip
    found = curves_of(job, session)
    assert (found.warnings, len(found.by_reading), len(searched)) == ((), 3, 1)

"""What tests of reports share."""

from __future__ import annotations

import pytest

NOTHING = (
    '<?xml version="1.0"?>\n<svg width="72pt" height="72pt" viewBox="0 0 72 72">'
    "<metadata></metadata></svg>"
)


@pytest.fixture
def words_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures are made but not drawn, which takes most of the time of a page.

    For tests of words; the tests of figures and of pages look at what is drawn.
    """
    monkeypatch.setattr("labrig.report.parts.figures.svg_text", lambda _fig: NOTHING)
    monkeypatch.setattr("labrig.report.parts.figures.save_all", lambda *_: [])

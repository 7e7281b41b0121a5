"""docs/effects.md says what the effects say."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from model.effects import LOCATIONS, catalogue
from model.effects.page import LOCATION_MEANINGS, page

PAGE = Path(__file__).parents[3] / "docs" / "effects.md"


def test_the_page_is_what_the_catalogue_makes():
    assert PAGE.read_text(encoding="utf-8") == page(), (
        "make it anew: python -m model.effects.page > docs/effects.md"
    )


def test_every_effect_and_slot_has_a_section():
    text = page()
    assert all(f"\n### {name}\n" in text for name in catalogue())
    assert set(LOCATION_MEANINGS) == set(LOCATIONS)


def test_the_page_is_printed_by_the_command_it_names():
    run = subprocess.run(
        [sys.executable, "-m", "model.effects.page"], capture_output=True, check=True
    )
    assert run.stdout.decode("utf-8") == page()

"""docs/effects.md says what the effects say."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from model.effects import catalogue
from model.effects.page import page
from model.locations import locations

PAGE = Path(__file__).parents[3] / "docs" / "effects.md"


def test_the_page_is_what_the_catalogue_makes():
    assert PAGE.read_text(encoding="utf-8") == page(), (
        "make it anew: python -m model.effects.page > docs/effects.md"
    )


def test_every_effect_and_slot_has_a_section():
    text = page()
    assert all(f"\n### {name}\n" in text for name in catalogue())
    assert all(f"\n## {name}: {one.meaning}\n" in text for name, one in locations().items())


def test_the_page_is_printed_by_the_command_it_names():
    run = subprocess.run(
        [sys.executable, "-m", "model.effects.page"], capture_output=True, check=True
    )
    assert run.stdout.decode("utf-8") == page()

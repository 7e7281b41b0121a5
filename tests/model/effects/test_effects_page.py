"""The page of effects says what the effects say."""

from __future__ import annotations

import subprocess
import sys

import pytest

from model.effects import catalogue
from model.effects.page import page
from model.locations import locations


def test_every_effect_and_slot_has_a_section():
    text = page()
    assert all(f"\n### {name}\n" in text for name in catalogue())
    assert all(f"\n## {name}: {one.meaning}\n" in text for name, one in locations().items())


@pytest.mark.slow
def test_the_page_is_printed_by_the_command_it_names():
    run = subprocess.run(
        [sys.executable, "-m", "model.effects.page"], capture_output=True, check=True
    )
    assert run.stdout.decode("utf-8") == page()

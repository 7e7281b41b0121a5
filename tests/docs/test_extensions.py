"""What Sphinx is taught: small functions of docs/extensions."""

from __future__ import annotations

from importlib import import_module

import pytest


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("at least 92 % of 48", "at least 92\u00a0% of 48"),
        ("a sheet of 50 mm, 0.6 s", "a sheet of 50\u00a0mm, 0.6\u00a0s"),
        ("10 minutes, 3 sheets, 2 modes", "10 minutes, 3 sheets, 2 modes"),
    ],
)
def test_a_number_is_not_parted_from_its_unit(text, kept):
    assert import_module("extensions.unbroken_units").unbroken(text) == kept

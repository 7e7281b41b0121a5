"""Warnings that are meant for the user are sentences on standard error."""

from __future__ import annotations

import warnings

import pytest

from drivers.plugins import PluginWarning
from labrig.cli.sentences.user_warnings import shown_as_sentences
from labrig.errors import RenamedKeyWarning


@pytest.mark.parametrize("category", [RenamedKeyWarning, PluginWarning])
@pytest.mark.filterwarnings("default")
def test_it_is_printed_once_and_without_the_place_in_the_code(
    category: type[Warning], capsys: pytest.CaptureFixture[str]
) -> None:
    with shown_as_sentences():
        for _ in range(2):
            warnings.warn("the key number is now called address.", category, stacklevel=1)
    assert capsys.readouterr().err == "labrig: the key number is now called address.\n"


def test_other_warnings_stay_pythons() -> None:
    with pytest.warns(UserWarning, match="of the others"), shown_as_sentences():
        warnings.warn("of the others", UserWarning, stacklevel=1)

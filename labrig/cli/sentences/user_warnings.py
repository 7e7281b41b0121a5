"""Warnings that are meant for the user, as sentences of the command line."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TextIO

from labrig.cli.screen import warn
from labrig.cli.sentences.option_names import with_options
from labrig.errors import ArgumentWarning, LabrigWarning, RenamedKeyWarning
from labrig.left_out import is_left_out, note


@contextmanager
def shown_as_sentences() -> Iterator[None]:
    """Print each warning that is meant for the user as a sentence.

    A part that is left out and a key that is renamed are named once.

    All other warnings are left to Python.
    """
    printed: set[str] = set()
    with warnings.catch_warnings():
        warnings.simplefilter("default", RenamedKeyWarning)  # Python hides those of its kind
        warnings.simplefilter("always", LabrigWarning)
        as_python_does = warnings.showwarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if category in (LabrigWarning, ArgumentWarning):
                warn(with_options(message))
                return
            if is_left_out(category):
                note(str(message))
            elif category is not RenamedKeyWarning:
                as_python_does(message, category, filename, lineno, file, line)
                return
            if str(message) not in printed:
                printed.add(str(message))
                warn(f"labrig: {message}")

        warnings.showwarning = show
        yield

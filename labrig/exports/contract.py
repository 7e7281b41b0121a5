"""What an export format is: a way to write a closed session for other programs.

A module of this folder is a format's when it has a `FORMAT`. Another distribution adds one by an
entry point of the group `labrig.exports`; the entry point's name is what `labrig export --as NAME`
asks for.
"""

from __future__ import annotations

from pathlib import Path
from typing import Protocol


class ExportFormat(Protocol):
    """A format: stateless. Packages that not every installation has are imported in `write`."""

    @property
    def summary(self) -> str:
        """One sentence, with its full stop: what is written."""
        ...

    @property
    def extra(self) -> str:
        """The extra that installs what `write` imports; empty where none is needed.

        It is labrig's, or that of the distribution that adds the format.
        """
        ...

    def write(self, session: Path, folder: Path) -> list[Path]:
        """Write the session into a folder, which exists, and return the files written.

        Called once, in the main thread; it may block for minutes. `session` is a closed session
        file, which must not be changed. Raises BadInputError where a file is there already or the
        session lacks what the format needs, and ModuleNotFoundError where a package is missing.
        A file appears under its final name whole, or not at all (`labrig.files`). Of another
        distribution `folder` is one aside: its files are moved when all of them are written.
        """
        ...

"""What a job is asked to do: one line of JSON on its standard input."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from labrig.errors import BadInputError
from labrig.serialise import from_json, to_json

Kind = Literal["run", "preflight", "weighing", "camera"]


@dataclass(frozen=True, kw_only=True)
class Order:
    """Paths are whole ones. Which are needed depends on the kind."""

    id: str
    kind: Kind
    by: str  # who asked for it
    wall: str
    data: str  # the data folder
    rig: str | None = None
    protocol: str | None = None
    sheet: str | None = None
    about: str | None = None  # text, in place of the about.toml beside rig.toml
    session: str | None = None  # to be made
    resume: str | None = None  # to go on with
    clock: Literal["real", "virtual"] = "virtual"  # of a simulated rig
    loads_mN: tuple[float, ...] = ()

    def to_json(self) -> str:
        """One line."""
        return to_json(self) + "\n"

    @classmethod
    def from_json(cls, text: str) -> Order:
        """Return the reverse. Raises BadInputError."""
        try:
            return from_json(cls, text)
        except ValueError as error:
            raise BadInputError(f"a job's order cannot be read ({error}).") from None

    def files(self) -> tuple[Path, Path, Path]:
        """rig.toml, protocol.toml, sheet.toml. Raises BadInputError when one is missing."""
        if self.rig is None or self.protocol is None or self.sheet is None:
            raise BadInputError("a run needs rig.toml, protocol.toml and sheet.toml.")
        return Path(self.rig), Path(self.protocol), Path(self.sheet)

    @property
    def session_name(self) -> str | None:
        """The session's name within the data folder."""
        if self.session is None:
            return None
        return Path(self.session).relative_to(self.data).as_posix()

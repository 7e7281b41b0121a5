"""The model that a command's arguments name: a file, or numbers of the user's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.api.eibm import Eibm
    from model import SheetModel


@dataclass(frozen=True)
class StatedModel:
    """A model file, or sheet.toml with a stiffness; and EIBMs in place of the model's."""

    path: Path
    eibm: Sequence[str]  # as the command line has them
    stiffness_Nm2: float | None

    def model(self) -> SheetModel:
        """Return the model. Raises BadInputError."""
        from labrig.api.eibm import model_with_eibm
        from labrig.model_file import load_model

        known = load_model(self.path) if self.stiffness_Nm2 is None else self._of_sheet()
        return model_with_eibm(known, self._by_voltage)

    @property
    def voltages(self) -> tuple[float, ...]:
        """The voltages whose EIBMs are the user's own."""
        return tuple(self._by_voltage)

    @cached_property
    def _by_voltage(self) -> dict[float, Eibm]:
        from labrig.api.eibm import parsed_eibm

        return parsed_eibm(self.eibm)

    def _of_sheet(self) -> SheetModel:
        from labrig.config import load_sheet
        from model import SheetModel
        from model.sheet.stated import stated_model

        if not self.eibm:
            raise BadInputError("--stiffness-Nm2: give the EIBM, too, such as --eibm 2=36e-6.")
        stiffness = self.stiffness_Nm2 or 0.0
        sheets = [stated_model(one, stiffness, {}) for one in load_sheet(self.path).values()]
        return SheetModel(sheets={name: s for one in sheets for name, s in one.sheets.items()})

"""A whole world: all tables of a world.toml, checked.

There are no defaults here: the shipped world.toml is the default, and a user's file says only what
differs from it. Keys are in the units of their names; properties and methods are SI.
"""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator

from sim_hardware.optics import OpticsSettings
from sim_hardware.world.settings.base import ClosedSettings, NotNegative, Ratio
from sim_hardware.world.settings.faults import FaultSettings
from sim_hardware.world.settings.moving import ElectrodeSettings, LossSettings, MassSettings
from sim_hardware.world.settings.rig import (
    AmplifierSettings,
    ArcSettings,
    CameraTriggerSettings,
    CellSettings,
    ClampSettings,
    ElectricalSettings,
    InterlockSettings,
    RollsSettings,
    ViewSettings,
    WiringSettings,
)
from sim_hardware.world.settings.sheet import (
    BumpOf,
    BumpSettings,
    CreepSettings,
    EibmSettings,
    SheetSettings,
    WaterSettings,
)

FloatArray = npt.NDArray[np.float64]


class ScatterSettings(ClosedSettings):
    """Standard deviations from one set-up to the next."""

    eibm: Ratio
    stiffness: Ratio
    position_mm: NotNegative
    clamp_tilt_rad: NotNegative
    registration_mm: NotNegative
    """Of the clamp's end in the image, in each direction."""


class ChainSettings(ClosedSettings):
    """The numerics."""

    link_mm: Annotated[float, Field(ge=0.02, le=1)]
    step_ms: Annotated[float, Field(ge=0.1, le=10)]
    """Of the time grid on which the sheet's state moves."""
    moving_links: Annotated[int, Field(ge=8, le=400)]
    """Of the sheet, in a moving world."""
    moving_step_ms: Annotated[float, Field(ge=0.01, le=2)]
    """Of a moving world's time grid."""


class WorldSettings(ClosedSettings):
    """A whole world."""

    seed: Annotated[int, Field(ge=0, lt=2**63)]
    moving: bool
    """Whether the sheet has mass, loss and electrodes; else it is at rest at each moment."""
    boards: Annotated[dict[str, str], Field(min_length=1)]
    """The rig's boards: a device's name and its product type."""
    wiring: WiringSettings
    arc: ArcSettings
    configurations: Annotated[dict[str, SheetSettings], Field(min_length=1)]
    eibm: EibmSettings
    water: WaterSettings
    amplifier: AmplifierSettings
    electrical: ElectricalSettings
    load_cell: CellSettings
    clamp: ClampSettings
    rolls: RollsSettings
    gravity_N_per_m: float
    """Weight of sheet per length that acts in the image's plane, along -y."""
    frame_delay_s: Annotated[float, Field(ge=0, le=1)]
    """The camera shows what was there so long ago."""
    creep: CreepSettings
    mass: MassSettings
    loss: LossSettings
    electrodes: ElectrodeSettings
    view: ViewSettings
    bumps: list[BumpSettings]
    scatter: ScatterSettings
    chain: ChainSettings
    camera: OpticsSettings
    interlock: InterlockSettings
    trigger: CameraTriggerSettings
    faults: list[FaultSettings]

    @model_validator(mode="after")
    def _can_move(self) -> Self:
        """Refuse what the equations of a moving sheet do not have."""
        if not self.moving:
            return self
        without = {
            "eibm.relaxation": self.eibm.relaxation,
            "creep.share": self.creep.share,
            "rolls.friction": self.rolls.friction,
            "rolls.offset_mm": self.rolls.offset_mm,
            "load_cell.compliance_mm_per_mN": self.load_cell.compliance_mm_per_mN,
            "clamp.compliance_mrad_per_Nmm": self.clamp.compliance_mrad_per_Nmm,
        }
        for name, sheet in self.configurations.items():
            table = f"configurations.{name}"
            without[f"{table}.stiffening"] = sheet.stiffening
            without[f"{table}.elongation_give"] = sheet.elongation_give
            without[f"{table}.elongation_joint_mm"] = sheet.elongation_joint_mm
        there = [f"{key} = {value:g}" for key, value in without.items() if value]
        if there:
            raise ValueError(
                f"a moving world does not know {', '.join(there)}; set it to 0, or moving = false"
            )
        return self

    def eibm_per_m(self, configuration: str, s_m: FloatArray) -> FloatArray:
        """Me/B along a sheet, settled at +2 V."""
        sheet = self.configurations[configuration]
        along = self.eibm.along_sheet(s_m, sheet.free_length_m)
        return sheet.eibm_ratio * along + self.bumped("eibm", configuration, s_m)

    def bumped(self, of: BumpOf, configuration: str, s_m: FloatArray) -> FloatArray:
        """Return the sum of the bumps of a property of a sheet."""
        result = np.zeros_like(s_m)
        for each in self.bumps:
            if each.of == of and each.configuration in ("", configuration):
                result += each.along(s_m)
        return result

"""The tables of a world.toml that act where `moving = true`: mass, loss and electrodes."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from sim_hardware.world.settings.base import ClosedSettings, NotNegative, Positive


class MassSettings(ClosedSettings):
    """What has to be accelerated."""

    density_kg_per_m3: Positive
    """Of the wet sheet with its electrodes."""
    elongation_kg_per_m: NotNegative
    end_kg: NotNegative
    """At the end of the elongation."""


class LossSettings(ClosedSettings):
    """What takes energy from a sheet that bends: B is the stiffness after all has relaxed."""

    viscous_ms: NotNegative
    """Kelvin-Voigt: viscous moment over elastic moment, per rate."""
    shares: list[Positive]
    """Prony: shares of B that a quick strain meets in addition, each ..."""
    times_s: list[Positive]
    """... with its time."""

    @model_validator(mode="after")
    def _in_pairs(self) -> Self:
        if len(self.shares) != len(self.times_s):
            raise ValueError(
                f"shares has {len(self.shares)} and times_s {len(self.times_s)} entries; "
                "each share needs its time"
            )
        return self


class ElectrodeSettings(ClosedSettings):
    """The electrodes as a line: both faces together, per length of sheet."""

    ohm_per_m: Positive
    capacitance_F_per_m: Positive
    bulk_ohm_m: Positive
    """Ionic resistance in series with the double layer."""
    leak_S_per_m: NotNegative
    source_ohm: NotNegative
    """Of shunt, contacts and amplifier together."""
    curvature_per_V_per_m: Annotated[float, Field(ge=-400, le=400)]
    """Me/B per volt of the double layer, at 2 V."""

"""What a fit may be asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from model.measurements import Condition, ModelError, is_at
from model.measurements.known_arguments import known_arguments

# configuration, position in m, and the voltage where only that is meant
HeldOut = tuple[str, float] | tuple[str, float, float]


@known_arguments
@dataclass(frozen=True, kw_only=True)
class FitOptions:
    """Options of `fit`; the defaults are the base model."""

    configurations: tuple[str, ...] | None = None  # None: all that were measured
    weight_exponent: float = 1.0  # q of (7)
    # how the EIBM may vary along the sheet while B is found; the reported constant is its mean
    eibm_form: Literal["along", "constant"] = "along"
    symmetric: bool = False  # one |EIBM| for both polarities
    measured_curvature: bool = False  # find k0 from the curves at 0 V although sheet.toml states it
    # how far k0 may be from what sheet.toml says, each term of it; 0: exact; None: 1 per m for a
    # sheet of the paper's size
    initial_curvature_sigma_per_m: float | None = None
    # conditions not used: (configuration or "" for all, position in m), or with the voltage in V
    # behind
    held_out: tuple[HeldOut, ...] = ()
    # B where no force was measured, which then stays as stated; None: that of a usual material
    stiffness_Nm2: float | None = None
    bootstrap: int = 0  # simulated refits that check the intervals
    seed: int = 0  # of the bootstrap

    def __post_init__(self) -> None:
        if self.weight_exponent < 0.0:
            raise ModelError("the weight exponent q must not be negative")
        if (self.initial_curvature_sigma_per_m or 0.0) < 0.0:
            raise ModelError("the tolerance of the initial curvature must not be negative")
        if self.bootstrap < 0:
            raise ModelError("the number of bootstrap samples must not be negative")

    def holds_out(self, condition: Condition) -> bool:
        """Whether a condition is one of those that are not used."""
        return any(is_held_out(condition, held) for held in self.held_out)


def is_held_out(condition: Condition, held: HeldOut) -> bool:
    """Whether a condition is one of those that an entry of `held_out` names."""
    name, position_m, *voltage_V = held
    return is_at(condition, name, position_m) and voltage_V in ([], [condition.voltage_V])

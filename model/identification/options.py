"""What a fit may be asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from model.measurements import Condition, ModelError

# configuration, position in m, and the voltage where only that is meant
HeldOut = tuple[str, float] | tuple[str, float, float]
_SAME_M = 1e-9


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
    # conditions not used: (configuration, position in m), or with the voltage in V behind
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


def is_held_out(condition: Condition, held: HeldOut) -> bool:
    """Whether a condition is one of those that an entry of `held_out` names."""
    return (
        condition.configuration == held[0]
        and condition.position_m is not None
        and abs(condition.position_m - held[1]) < _SAME_M
        and (len(held) == 2 or condition.voltage_V == held[2])
    )

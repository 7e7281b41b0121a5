"""What a fit may be asked for."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from model.measurements import (
    Condition,
    ModelError,
    is_at,
    require_number,
    require_truth,
    require_whole_number,
)
from model.measurements.known_arguments import known_arguments

# configuration, position in m, and the voltage where only that is meant
HeldOut = tuple[str, float] | tuple[str, float, float]
_PLACE = '("long", 0.025)'


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
        _require_names("configurations", self.configurations)
        require_number("weight_exponent", self.weight_exponent)
        if self.weight_exponent < 0.0:
            raise ModelError("the weight exponent q must not be negative")
        if self.eibm_form not in ("along", "constant"):
            raise ModelError(f"eibm_form {self.eibm_form!r} is none of along, constant")
        require_truth("symmetric", self.symmetric)
        require_truth("measured_curvature", self.measured_curvature)
        if self.initial_curvature_sigma_per_m is not None:
            require_number("initial_curvature_sigma_per_m", self.initial_curvature_sigma_per_m)
        if (self.initial_curvature_sigma_per_m or 0.0) < 0.0:
            raise ModelError("the tolerance of the initial curvature must not be negative")
        for held in _entries(self.held_out):
            _require_place(held)
        if self.stiffness_Nm2 is not None:
            require_number("stiffness_Nm2", self.stiffness_Nm2, above=0.0)
        require_whole_number("bootstrap", self.bootstrap, at_least=0)
        require_whole_number("seed", self.seed, at_least=0)

    def holds_out(self, condition: Condition) -> bool:
        """Whether a condition is one of those that are not used."""
        return any(is_held_out(condition, held) for held in self.held_out)


def is_held_out(condition: Condition, held: HeldOut) -> bool:
    """Whether a condition is one of those that an entry of `held_out` names."""
    name, position_m, *voltage_V = held
    return is_at(condition, name, position_m) and voltage_V in ([], [condition.voltage_V])


def _require_names(name: str, given: object) -> None:
    """Refuse what is no tuple of texts: the letters of one text would each be a name."""
    named = isinstance(given, tuple | list) and all(isinstance(one, str) for one in given)
    if given is not None and not named:
        raise ModelError(f"{name} {given!r}: a tuple of names is needed, such as ('long',)")


def _entries(held_out: object) -> Iterable[object]:
    """Return the entries of `held_out`; one that stands alone has none in it."""
    if isinstance(held_out, tuple | list):
        return held_out
    raise ModelError(f"held_out {held_out!r}: a tuple of places is needed, such as ({_PLACE},)")


def _require_place(held: object) -> None:
    """Refuse an entry that is no configuration with its position, and its voltage where given."""
    if not isinstance(held, tuple | list) or len(held) not in (2, 3):
        raise ModelError(
            f"held_out: {held!r} is no place, such as {_PLACE}; several are a tuple of them"
        )
    if not isinstance(held[0], str):
        raise ModelError(f"held_out: the configuration of {held!r} must be a text, {_PLACE}")
    for value in held[1:]:
        require_number(f"held_out {held!r}:", value)

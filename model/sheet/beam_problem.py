"""What a beam problem is made of, before it is solved: the place where effects act.

Effects of a model change a `ConditionProblem` before it is solved: see `applied_effects`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from model.measurements import FloatArray, ModelError, SheetGeometry
from model.mechanics.field import Field
from model.parameter import Parameter, finite

Coordinate = Literal["s", "position", "force", "time"]
Under = Literal["", "voltage", "polarity"]


@dataclass(frozen=True, kw_only=True)
class ConditionProblem:
    """One configuration at one position and voltage."""

    sheet: SheetGeometry
    voltage_V: float
    angle_rad: float  # polar angle of the contact; NaN: nothing touches the sheet
    B_Nm2: float  # the reference stiffness
    rest: Field  # k0(s)
    eibm: Field  # Me(s), and every other moment that is not the contact's
    softness: Field | None = None  # B/B(s); None: the same stiffness everywhere
    clamp_rad: float = 0.0  # direction in which the sheet leaves the clamp
    elongation_soft: float = 0.0  # B over the elongation's stiffness; 0: rigid
    offset_m: float = 0.0  # from the neutral curve to the point on the arc, along the normal

    @property
    def touches(self) -> bool:
        """Whether there is a contact."""
        return bool(np.isfinite(self.angle_rad))


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Numbers along a coordinate: straight lines between nodes, constant beyond the outer ones."""

    along: Coordinate  # s: m from the clamp; position: m on the arc; force: N; time: s
    at: tuple[float, ...]
    values: tuple[float, ...]
    sigma: tuple[float, ...]
    unit: str  # of the values; empty: factors
    under: Under = ""  # voltage: not at 0 V; polarity: the other way at the other polarity

    def __call__(self, at: FloatArray) -> FloatArray:
        """Values there."""
        result: FloatArray = np.interp(at, self.at, self.values)
        return result

    def share(self, voltage_V: FloatArray) -> FloatArray:
        """1, 0 or -1: which way it acts at these voltages."""
        sign = np.sign(voltage_V)
        return {"": np.ones_like(sign), "voltage": np.abs(sign), "polarity": sign}[self.under]

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        result = {
            "along": self.along, "at": list(self.at), "value": list(self.values),
            "sigma": list(self.sigma), "unit": self.unit,
        }  # fmt: skip
        return {**result, "under": self.under} if self.under else result

    @staticmethod
    def from_dict(data: object, where: str) -> Profile:
        """From a model file; `where` names the place in errors."""
        if not isinstance(data, dict) or data.get("along") not in get_args(Coordinate):
            allowed = ", ".join(get_args(Coordinate))
            raise ModelError(
                f"{where}: a table with along (one of {allowed}), at and value is wanted"
            )
        rows = {}
        for key in ("at", "value", "sigma"):
            row = data.get(key)
            if not isinstance(row, list) or not row:
                raise ModelError(f"{where}.{key}: a list of numbers is wanted")
            rows[key] = tuple(finite(v, f"{where}.{key}") for v in row)
        if not len(rows["at"]) == len(rows["value"]) == len(rows["sigma"]):
            raise ModelError(f"{where}: at, value and sigma must be equally long")
        if any(b <= a for a, b in zip(rows["at"], rows["at"][1:], strict=False)):
            raise ModelError(f"{where}.at: the places must ascend")
        under = data.get("under", "")
        if under not in get_args(Under):
            raise ModelError(f"{where}.under: one of voltage, polarity is wanted, or none")
        return Profile(
            along=data["along"], at=rows["at"], values=rows["value"], sigma=rows["sigma"],
            unit=str(data.get("unit", "")), under=under,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class ActiveEffect:
    """An effect that a model includes, by its name in the catalogue.

    The name `unknown` stands for something that is in no catalogue: it has a location, and its
    profile says what is added there.
    """

    name: str
    parameters: Mapping[str, Parameter] = field(default_factory=dict)  # of all configurations
    # where a configuration has values of its own
    by_configuration: Mapping[str, Mapping[str, Parameter]] = field(default_factory=dict)
    # factors on the catalogue's form (named effects), or the term itself (`unknown`)
    profile: Profile | None = None
    location: str = ""  # of `unknown`
    configurations: tuple[str, ...] = ()  # in which it acts; empty: all

    def values(self, configuration: str) -> dict[str, float] | None:
        """Numbers by name for a configuration; None where the effect does not act."""
        if self.configurations and configuration not in self.configurations:
            return None
        own = self.by_configuration.get(configuration)
        if own is None and self.by_configuration and not self.parameters:
            return None
        return {k: p.value for k, p in {**self.parameters, **(own or {})}.items()}

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        result: dict[str, Any] = {"name": self.name}
        if self.location:
            result["slot"] = self.location
        if self.configurations:
            result["configurations"] = list(self.configurations)
        result["parameters"] = {k: p.to_dict() for k, p in self.parameters.items()}
        if self.by_configuration:
            result["by_configuration"] = {
                name: {k: p.to_dict() for k, p in own.items()}
                for name, own in self.by_configuration.items()
            }
        if self.profile is not None:
            result["profile"] = self.profile.to_dict()
        return result

    @staticmethod
    def from_dict(data: object, where: str) -> ActiveEffect:
        """From a model file; `where` names the place in errors."""
        if not isinstance(data, dict) or not isinstance(data.get("name"), str):
            raise ModelError(f"{where}: a table with a name is wanted")
        own = data.get("by_configuration", {})
        names = data.get("configurations", [])
        if not isinstance(own, dict):
            raise ModelError(f"{where}.by_configuration: a table is wanted")
        if not isinstance(names, list) or not all(isinstance(n, str) for n in names):
            raise ModelError(f"{where}.configurations: a list of names is wanted")
        profile = data.get("profile")
        return ActiveEffect(
            name=data["name"],
            parameters=_parameters(data.get("parameters", {}), f"{where}.parameters"),
            by_configuration={
                name: _parameters(one, f"{where}.by_configuration.{name}")
                for name, one in own.items()
            },
            profile=None if profile is None else Profile.from_dict(profile, f"{where}.profile"),
            location=str(data.get("slot", "")),
            configurations=tuple(names),
        )


def _parameters(data: object, where: str) -> dict[str, Parameter]:
    if not isinstance(data, dict):
        raise ModelError(f"{where}: a table is wanted")
    return {k: Parameter.from_dict(p, f"{where}.{k}") for k, p in data.items()}

"""What a beam problem is made of, before it is solved: the place where effects act.

Effects of a model change a `ConditionProblem` before it is solved: see `applied_effects`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

import numpy as np

from model.locations.quantities import wave_count
from model.measurements import FloatArray, ModelError, SheetGeometry
from model.mechanics.field import Field
from model.parameter import Parameter, finite

Coordinate = Literal[
    "s", "curvature", "bending", "position", "voltage", "configuration", "force", "pulse", "run",
    "session", "driven", "time", "clamp", "image_x", "image_y", "fine_x", "fine_y",
]  # fmt: skip
Under = Literal["", "voltage", "polarity"]
Adds = Literal[
    "",
    "EIBM",
    "stiffness",
    "force",
    "stress",
    "gain",
    "clamp",
    "curvature",
    "bow",
    "moment",
    "reach",
]
UNKNOWN = "unknown"  # the name of what is in no catalogue
TINY = 1e-12
STANDARD = 0.6827  # probability of an interval of one standard uncertainty to each side


@dataclass(frozen=True, kw_only=True)
class ConditionProblem:
    """One configuration at one position and voltage."""

    sheet: SheetGeometry
    voltage_V: float
    angle_rad: float  # polar angle of the contact; NaN: nothing touches the sheet
    B_Nm2: float  # the reference stiffness
    rest: Field  # k0(s)
    eibm: Field  # Me(s), and every other moment that is not the contact's
    induced: Field | None = None  # Me(s) alone; None: there is no other moment
    opposite_ratio: float = 1.0  # |EIBM(-)/EIBM(+)| at the clamp
    softness: Field | None = None  # B/B(s); None: the same stiffness everywhere
    clamp_rad: float = 0.0  # direction in which the sheet leaves the clamp
    elongation_soft: float = 0.0  # B over the elongation's stiffness; 0: rigid
    offset_m: float = 0.0  # from the neutral curve to the point on the arc, along the normal
    reach_m: float = 0.0  # of that point beyond the stated arc, away from its centre
    session: int = 0  # number of the session it stands for; 0: of none in particular
    measured_length_m: float = 0.0  # of the sheet it is cut from; 0: it is the measured one

    @property
    def touches(self) -> bool:
        """Whether there is a contact."""
        return bool(np.isfinite(self.angle_rad))


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Numbers along a coordinate: straight lines between nodes, constant beyond the outer ones.

    Coordinates: s, m from the clamp; curvature, 1/m by which the sheet is bent; bending, the same
    with its sign; position, m on the arc; voltage, V; force, N; pulse, run, s since the voltage was
    set, since the run began; driven, s under voltage since the sheet was wetted; session, 0 .. 1;
    image_x, image_y, fine_x, fine_y, the number of a wave across the image; configuration and clamp
    have one node.
    What goes with `time`, as older files have it, is in no mean.
    """

    along: Coordinate
    at: tuple[float, ...]
    values: tuple[float, ...]
    sigma: tuple[float, ...]
    unit: str  # of the values; empty: factors
    under: Under = ""  # voltage: not at 0 V; polarity: the other way at the other polarity
    adds: Adds = ""  # to what it is added, where that does not follow from the coordinate
    configurations: tuple[str, ...] = ()  # in which it acts; empty: all
    # the least voltage at which it was inferred; what is odd in the voltage goes in proportion to
    # it below that, what is even as `even` says; 0: it is the same at all
    full_V: float = 0.0

    def __call__(self, at: FloatArray) -> FloatArray:
        """Values there; in the middle where there is no coordinate."""
        middle = 0.5 * (self.at[0] + self.at[-1])
        result: FloatArray = np.interp(np.nan_to_num(at, nan=middle), self.at, self.values)
        return result

    def share(self, voltage_V: FloatArray) -> FloatArray:
        """1, 0 or -1: which way it acts at these voltages."""
        sign, part = np.sign(voltage_V), self.part(voltage_V)
        if self.under == "voltage":
            return np.abs(sign) * self.even(voltage_V)
        return np.ones_like(sign) if not self.under else sign * part

    def part(self, voltage_V: FloatArray) -> FloatArray:
        """Share of the least voltage at which it was inferred, 1 from there on."""
        if not self.full_V:
            return np.ones_like(voltage_V)
        return np.minimum(np.abs(voltage_V) / self.full_V, 1.0)

    def even(self, voltage_V: FloatArray) -> FloatArray:
        """Share of what is the same at both polarities.

        Nothing measured says how it begins: with the charge, or with its square. It is the mean
        over all powers between the two, x (x - 1)/ln x.
        """
        x = self.part(voltage_V)
        log = np.minimum(np.log(np.maximum(x, TINY)), -TINY)
        mean: FloatArray = np.where(x < 1.0, x * np.expm1(log) / log, 1.0)
        return mean

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        result: dict[str, Any] = {
            "along": self.along, "at": list(self.at), "value": list(self.values),
            "sigma": list(self.sigma), "unit": self.unit,
        }  # fmt: skip
        for key in ("under", "adds", "full_V"):
            if getattr(self, key):
                result[key] = getattr(self, key)
        if self.configurations:
            result["configurations"] = list(self.configurations)
        return result

    @staticmethod
    def from_dict(data: object, where: str) -> Profile:
        """From a model file; `where` names the place in errors."""
        if not isinstance(data, dict) or data.get("along") not in get_args(Coordinate):
            allowed = ", ".join(get_args(Coordinate))
            raise ModelError(
                f"{where}: a table with along (one of {allowed}), at and value is wanted"
            )
        rows = _nodes(data, where)
        words = {}
        for key, choices in (("under", get_args(Under)), ("adds", get_args(Adds))):
            words[key] = data.get(key, "")
            if words[key] not in choices:
                some = ", ".join(choices[1:])
                raise ModelError(f"{where}.{key}: one of {some} is wanted, or none")
        full_V = finite(data.get("full_V", 0.0), f"{where}.full_V")
        if full_V < 0.0:
            raise ModelError(f"{where}.full_V: a voltage above 0 is wanted, or none")
        return Profile(
            along=data["along"], at=rows["at"], values=rows["value"], sigma=rows["sigma"],
            unit=str(data.get("unit", "")), under=words["under"], adds=words["adds"],
            configurations=_names(data, where),
            full_V=full_V,
        )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class ActiveEffect:
    """An effect that a model includes, by its name in the catalogue.

    The name `unknown` stands for something that is in no catalogue: it has a location, and its
    form says what is added there.
    """

    name: str
    parameters: Mapping[str, Parameter] = field(default_factory=dict)  # of all configurations
    # where a configuration has values of its own
    by_configuration: Mapping[str, Mapping[str, Parameter]] = field(default_factory=dict)
    # Where its form differs from the catalogue's: it is that times 1 + the sum of these terms, but
    # for those that add to something. Of `unknown`: the terms themselves.
    form: tuple[Profile, ...] = ()
    # as older files have it: factors on the catalogue's form, or the term itself (`unknown`)
    profile: Profile | None = None
    location: str = ""  # of `unknown`
    configurations: tuple[str, ...] = ()  # in which it acts; empty: all
    # in which it is what the dynamics leave, of an effect that these have a part of
    beside_dynamics: tuple[str, ...] = ()
    distribution: str = ""  # whose it is, with its version; empty: labrig's own
    # of the camera: whether it moves points across the curve alone, not along it
    across_curve: bool = False

    def values(self, configuration: str) -> dict[str, float] | None:
        """Numbers by name for a configuration; None where the effect does not act."""
        known = self._acting(configuration)
        return None if known is None else {name: one.value for name, one in known.items()}

    def varied(self, configuration: str) -> list[tuple[ActiveEffect, ActiveEffect]]:
        """Return for each uncertain parameter the effect at the ends of its standard interval."""
        known = self._acting(configuration) or {}
        return [
            (self._with(configuration, name, ends[1]), self._with(configuration, name, ends[0]))
            for name, one in known.items()
            if one.sigma > 0.0
            for ends in [one.interval(STANDARD)]
        ]

    def names(self, configuration: str) -> tuple[str, ...]:
        """Return the names of its parameters in a configuration; none where it does not act."""
        return tuple(self._acting(configuration) or ())

    def moved(self, configuration: str, change: Mapping[str, float]) -> ActiveEffect:
        """Return the effect with parameters changed; what is positive, by factors."""
        known, result = self._acting(configuration) or {}, self
        for name, much in change.items():
            one = known[name]
            grown = one.value * np.exp(much / one.value) if one.positive else one.value + much
            result = result._with(configuration, name, float(np.clip(grown, one.low, one.high)))
        return result

    def _acting(self, configuration: str) -> dict[str, Parameter] | None:
        if self.configurations and configuration not in self.configurations:
            return None
        own = self.by_configuration.get(configuration)
        if own is None and self.by_configuration and not self.parameters:
            return None
        return {**self.parameters, **(own or {})}

    def _with(self, configuration: str, name: str, value: float) -> ActiveEffect:
        own = self.by_configuration.get(configuration, {})
        if name not in own:
            shared = {**self.parameters, name: replace(self.parameters[name], value=value)}
            return replace(self, parameters=shared)
        changed = {**own, name: replace(own[name], value=value)}
        return replace(self, by_configuration={**self.by_configuration, configuration: changed})

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        result: dict[str, Any] = {"name": self.name}
        if self.location:
            result["slot"] = self.location
        if self.configurations:
            result["configurations"] = list(self.configurations)
        if self.beside_dynamics:
            result["beside_dynamics"] = list(self.beside_dynamics)
        if self.distribution:
            result["distribution"] = self.distribution
        if self.across_curve:
            result["across_curve"] = True
        result["parameters"] = {k: p.to_dict() for k, p in self.parameters.items()}
        if self.by_configuration:
            result["by_configuration"] = {
                name: {k: p.to_dict() for k, p in own.items()}
                for name, own in self.by_configuration.items()
            }
        if self.profile is not None:
            result["profile"] = self.profile.to_dict()
        if self.form:
            result["form"] = [term.to_dict() for term in self.form]
        return result

    @property
    def terms(self) -> tuple[Profile, ...]:
        """All terms of its form, those of older files among them."""
        old = self.profile
        if old is None:
            return self.form
        if self.name != UNKNOWN:
            old = replace(old, values=tuple(v - 1.0 for v in old.values))
        return (*self.form, old)

    @staticmethod
    def from_dict(data: object, where: str) -> ActiveEffect:
        """From a model file; `where` names the place in errors."""
        if not isinstance(data, dict) or not isinstance(data.get("name"), str):
            raise ModelError(f"{where}: a table with a name is wanted")
        for key in data:
            if key not in _KEYS:
                known = ", ".join(_KEYS)
                raise ModelError(f"{where}.{key}: an effect has no such key; it has {known}")
        own = data.get("by_configuration", {})
        if not isinstance(own, dict):
            raise ModelError(f"{where}.by_configuration: a table is wanted")
        profile, form = data.get("profile"), data.get("form", [])
        across_curve = data.get("across_curve", False)
        if not isinstance(across_curve, bool):
            raise ModelError(f"{where}.across_curve: true or false is wanted")
        if not isinstance(form, list):
            raise ModelError(f"{where}.form: a list of tables is wanted")
        return ActiveEffect(
            name=data["name"],
            parameters=_parameters(data.get("parameters", {}), f"{where}.parameters"),
            by_configuration={
                name: _parameters(one, f"{where}.by_configuration.{name}")
                for name, one in own.items()
            },
            form=tuple(
                Profile.from_dict(term, f"{where}.form[{i}]") for i, term in enumerate(form)
            ),
            profile=None if profile is None else Profile.from_dict(profile, f"{where}.profile"),
            location=str(data.get("slot", "")),
            configurations=_names(data, where),
            beside_dynamics=_names(data, where, "beside_dynamics"),
            distribution=str(data.get("distribution", "")),
            across_curve=across_curve,
        )


_KEYS = (
    "name", "parameters", "by_configuration", "configurations", "form", "profile", "slot",
    "across_curve", "beside_dynamics", "distribution",
)  # fmt: skip


def _counts(numbers: tuple[float, ...], many: int) -> bool:
    """Return whether they are 0, 1, 2 and so on: as a file has them, up to rounding."""
    return len(numbers) == many and bool(np.allclose(numbers, np.arange(many), atol=1e-6))


def _nodes(data: dict[str, Any], where: str) -> dict[str, tuple[float, ...]]:
    """Return nodes, values and sigmas of a term, by their keys."""
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
    waves = wave_count(data["along"])
    if waves and not _counts(rows["at"], waves):
        raise ModelError(
            f"{where}.at: the numbers of the {waves} waves across the image are wanted, 0 to"
            f" {waves - 1}"
        )
    return rows


def _names(data: dict[str, Any], where: str, key: str = "configurations") -> tuple[str, ...]:
    names = data.get(key, [])
    if not isinstance(names, list) or not all(isinstance(n, str) for n in names):
        raise ModelError(f"{where}.{key}: a list of names is wanted")
    return tuple(names)


def _parameters(data: object, where: str) -> dict[str, Parameter]:
    if not isinstance(data, dict):
        raise ModelError(f"{where}: a table is wanted")
    return {k: Parameter.from_dict(p, f"{where}.{k}") for k, p in data.items()}

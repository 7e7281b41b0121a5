"""One configuration's parameters: bending stiffness, rest curvature, EIBM along the sheet."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from model.measurements import Displayed, FloatArray, ModelError, SheetGeometry, Summary, in_digits
from model.mechanics.field import Field
from model.parameter import Parameter, finite

_LENGTHS = {
    "free_length_mm": "free_length_m", "width_mm": "width_m", "thickness_mm": "thickness_m",
    "elongation_mm": "elongation_m", "clamped_length_mm": "clamped_length_m",
    "arc_radius_mm": "arc_radius_m",
}  # fmt: skip
FITTED = "fitted_positions_mm"  # of a configuration in a model file
SAME_V = 1e-6  # relative: a voltage this close to one that was fitted is that one
NEAR_M = 5e-4  # a position this close to those fitted is one of them


@dataclass(frozen=True, repr=False)
class Along(Displayed):
    """A quantity along the sheet: nodes, straight lines between; one node: the same everywhere."""

    s_m: FloatArray
    values: FloatArray
    sigma: FloatArray
    unit: str

    def summary(self) -> Summary:
        """Return its range along the sheet."""
        first, last = float(self.values[0]), float(self.values[-1])
        if len(self.s_m) == 1:
            return Summary(f"Along: {first:.4g} {self.unit} everywhere")
        return Summary(
            f"Along: {first:.4g} to {last:.4g} {self.unit}, {len(self.s_m)} nodes from "
            f"{1e3 * self.s_m[0]:.4g} to {1e3 * self.s_m[-1]:.4g} mm"
        )

    @staticmethod
    def constant(parameter: Parameter) -> Along:
        """Return the same parameter everywhere along the sheet."""
        return Along(
            np.zeros(1), np.array([parameter.value]), np.array([parameter.sigma]), parameter.unit
        )

    def field(self, length_m: float) -> Field:
        """For computing with."""
        return Field.linear(self.s_m, self.values, length_m)

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        return {
            "s_m": self.s_m.tolist(), "value": self.values.tolist(),
            "sigma": self.sigma.tolist(), "unit": self.unit,
        }  # fmt: skip

    @staticmethod
    def from_dict(data: object, where: str) -> Along:
        """From a model file."""
        if not isinstance(data, dict):
            raise ModelError(f"{where}: a table with s_m, value, sigma and unit is wanted")
        rows = {}
        for key in ("s_m", "value", "sigma"):
            row = data.get(key)
            if not isinstance(row, list) or not row:
                raise ModelError(f"{where}.{key}: a list of numbers is wanted")
            rows[key] = np.array([finite(v, f"{where}.{key}") for v in row])
        if not len(rows["s_m"]) == len(rows["value"]) == len(rows["sigma"]):
            raise ModelError(f"{where}: s_m, value and sigma must be equally long")
        return Along(rows["s_m"], rows["value"], rows["sigma"], str(data.get("unit", "")))


@dataclass(frozen=True, repr=False)
class ConfiguredSheet(Displayed):
    """One configuration's parameters."""

    sheet: SheetGeometry
    B: Parameter  # N m^2
    rest: Along  # k0, 1/m
    eibm: Mapping[float, Along]  # by voltage, N m

    def summary(self) -> Summary:
        """Return B, E and the mean EIBM of each voltage."""
        rows = [
            ("bending stiffness B", *_said(self.B, 1e6), "µN m²"),
            ("equivalent Young modulus E", *_said(self.E, 1e-6), "MPa"),
            *(
                (f"EIBM at {v:+g} V, {_form(along)}", *_said(self._mean(v), 1e6), "µN m")
                for v, along in sorted(self.eibm.items(), reverse=True)
            ),
        ]
        columns = ("parameter", "value", "sigma", "unit")
        return Summary(f"ConfiguredSheet: {self.sheet.summary().title}", columns, rows)

    def _mean(self, voltage_V: float) -> Parameter:
        sigma = float(np.sqrt(np.mean(self.eibm[voltage_V].sigma ** 2)))
        return Parameter(value=self.mean_eibm(voltage_V), sigma=sigma, unit="N m")

    @property
    def E(self) -> Parameter:
        """(6) equivalent Young modulus."""
        return self.B.scaled(12.0 / (self.sheet.width_m * self.sheet.thickness_m**3), "Pa")

    def eibm_at(self, voltage_V: float) -> Field:
        """Me(s) at a voltage: known at the fitted ones and 0 V, in proportion between."""
        length = self.sheet.free_length_m
        volts = sorted({0.0, *self.eibm})
        # one of a float32 array differs from what was fitted in its eighth digit
        voltage_V = next((v for v in volts if abs(v - voltage_V) <= SAME_V * abs(v)), voltage_V)
        if not volts[0] <= voltage_V <= volts[-1]:
            known = f"{volts[0]:g} V to {volts[-1]:+g} V" if len(volts) > 1 else "0 V alone"
            raise ModelError(
                f"the model of '{self.sheet.configuration}' knows {known};"
                f" {voltage_V:+g} V is outside"
            )
        if voltage_V in self.eibm:
            return self.eibm[voltage_V].field(length)
        if voltage_V == 0.0:
            return Field.constant(0.0, length)
        high = next(i for i, v in enumerate(volts) if v > voltage_V)
        low_V, high_V = volts[high - 1], volts[high]
        share = (voltage_V - low_V) / (high_V - low_V)
        return self.eibm_at(low_V) * (1.0 - share) + self.eibm_at(high_V) * share

    def mean_eibm(self, voltage_V: float) -> float:
        """Mean of Me over the free length."""
        return self.eibm_at(voltage_V).mean(self.sheet.free_length_m)

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        geometry: dict[str, Any] = {
            key: round(getattr(self.sheet, name) * 1e3, 12) for key, name in _LENGTHS.items()
        }
        geometry["arc_origin_deg"] = float(np.degrees(self.sheet.arc_origin_rad))
        geometry["rise_time_s"] = self.sheet.rise_time_s
        return {
            "geometry": geometry,
            "B_Nm2": self.B.to_dict(),
            "E_Pa": self.E.to_dict(),
            "initial_curvature": self.rest.to_dict(),
            "eibm": {str(float(v)): along.to_dict() for v, along in sorted(self.eibm.items())},
        }

    @staticmethod
    def from_dict(name: str, data: object) -> ConfiguredSheet:
        """From a model file; errors name the key."""
        where = f"configurations.{name}"
        if not isinstance(data, dict):
            raise ModelError(f"{where}: a table is wanted")
        geometry = table(data, "geometry", where)
        lengths = {
            field_name: finite(geometry.get(key, 0.0), f"{where}.geometry.{key}") * 1e-3
            for key, field_name in _LENGTHS.items()
        }
        for key in ("free_length_mm", "width_mm", "thickness_mm", "arc_radius_mm"):
            if lengths[_LENGTHS[key]] <= 0.0:
                raise ModelError(f"{where}.geometry.{key}: must be positive")
        rest = Along.from_dict(data.get("initial_curvature"), f"{where}.initial_curvature")
        sheet = SheetGeometry(
            configuration=name,
            arc_origin_rad=float(np.radians(finite(geometry.get("arc_origin_deg", 0.0), where))),
            initial_curvature=(rest.s_m, rest.values),
            rise_time_s=finite(geometry.get("rise_time_s", 0.0), f"{where}.geometry.rise_time_s"),
            **lengths,
        )
        B = Parameter.from_dict(data.get("B_Nm2"), f"{where}.B_Nm2")
        if B.value <= 0.0:
            raise ModelError(f"{where}.B_Nm2.value: the bending stiffness must be positive")
        eibm = {
            _voltage(v, where): Along.from_dict(one, f"{where}.eibm.{v}")
            for v, one in table(data, "eibm", where).items()
        }
        return ConfiguredSheet(sheet, B, rest, eibm)


@dataclass(frozen=True)
class FittedPositions:
    """The least and the largest one."""

    low_m: float
    high_m: float

    @staticmethod
    def of(positions_m: Iterable[float]) -> FittedPositions | None:
        """Return those of some positions; None: there is none."""
        every = list(positions_m)
        return FittedPositions(min(every), max(every)) if every else None

    def beyond(self, position_m: float) -> str:
        """Return a remark on a position that lies outside; else nothing."""
        if self.low_m - NEAR_M <= position_m <= self.high_m + NEAR_M:
            return ""
        low, high = f"{1e3 * self.low_m:g}", f"{1e3 * self.high_m:g}"
        return f"beyond the positions fitted ({low if low == high else f'{low} to {high}'} mm)"

    def to_dict(self) -> list[float]:
        """For a model file."""
        return [round(1e3 * one, 12) for one in (self.low_m, self.high_m)]

    @staticmethod
    def from_dict(data: dict[str, Any], where: str) -> FittedPositions | None:
        """From the table of a configuration; None: it does not state them."""
        if FITTED not in data:
            return None
        ends, where = data[FITTED], f"{where}.{FITTED}"
        if not isinstance(ends, list) or len(ends) != 2:
            raise ModelError(f"{where}: the least and the largest position are wanted")
        low, high = (1e-3 * finite(one, where) for one in ends)
        if low > high:
            raise ModelError(f"{where}: the least position comes first")
        return FittedPositions(low, high)


def _said(parameter: Parameter, factor: float) -> tuple[str, str]:
    """Return value and standard uncertainty in another unit."""
    sigma = in_digits(factor * parameter.sigma, 2) if parameter.sigma else "-"
    return in_digits(factor * parameter.value, 4), sigma


def _form(along: Along) -> str:
    return "constant" if np.ptp(along.values) == 0.0 else "mean along the sheet"


def _voltage(text: object, where: str) -> float:
    try:
        return float(str(text))
    except ValueError:
        raise ModelError(f"{where}.eibm: '{text}' is not a voltage") from None


def table(data: dict[str, Any], key: str, where: str = "") -> dict[str, Any]:
    """Return a table of a model file; errors name the key."""
    found = data.get(key)
    if not isinstance(found, dict):
        raise ModelError(f"{where}{'.' if where else ''}{key}: a table is wanted")
    return found

"""`DynamicSheet`: what a model file says of one sheet in time, with standard uncertainties.

Geometry, relaxed stiffness and initial curvature are those of the file's configuration.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from model.dynamics.beam import ContactSetup, DynamicBeam, Elongation
from model.dynamics.fluid import VACUUM, FluidLoad, fluid_load
from model.dynamics.line import ElectrodeLine
from model.dynamics.material import Viscoelasticity
from model.measurements import ModelError, SheetGeometry
from model.mechanics.field import Field
from model.parameter import Parameter, finite

# at which the added mass and the linear drag are taken: the long sheet's first mode
AIR_FREQUENCY_HZ, WATER_FREQUENCY_HZ = 3.3, 0.71
FLUIDS = ("air", "water", "vacuum")
_POSITIVE = (
    "mass_per_length_kg_per_m",
    "electrode_ohm_per_m",
    "capacitance_F_per_m",
    "bulk_ohm_m",
    "source_ohm",
)
_NOT_NEGATIVE = ("viscous_time_s", "leak_S_per_m")


@dataclass(frozen=True, kw_only=True)
class PronyTerm:
    """One term of the Prony series."""

    share: Parameter  # of the relaxed stiffness
    time_s: Parameter


@dataclass(frozen=True, kw_only=True)
class LoadCellResonance:
    """The load cell's own resonance."""

    resonance_hz: Parameter
    damping: Parameter  # damping ratio


@dataclass(frozen=True, kw_only=True)
class DynamicSheet:
    """Mass, loss, electrodes and surroundings of one configuration."""

    mass_per_length_kg_per_m: Parameter
    viscous_time_s: Parameter
    electrode_ohm_per_m: Parameter
    capacitance_F_per_m: Parameter
    bulk_ohm_m: Parameter
    leak_S_per_m: Parameter
    source_ohm: Parameter
    moment_per_volt_Nm: tuple[Parameter, Parameter]  # for U > 0, for U < 0
    prony: tuple[PronyTerm, ...] = ()
    fluid: str = "air"
    load_cell: LoadCellResonance | None = None
    elongation_mass_kg_per_m: Parameter | None = None  # needed where there is an elongation
    # what determined a parameter, by its key: "data", "prior", "stated"
    determined_by: Mapping[str, str] = field(default_factory=dict)

    def beam(self, sheet: SheetGeometry, B_Nm2: float, rest: Field) -> DynamicBeam:
        """Return the sheet in numbers. Raises ModelError where a number is missing or bad."""
        mass = self.elongation_mass_kg_per_m
        if sheet.elongation_m > 0.0 and mass is None:
            raise ModelError(
                f"the dynamic model of '{sheet.configuration}' needs elongation_mass_kg_per_m"
            )
        around = fluid_around(self.fluid, sheet.width_m)
        return DynamicBeam(
            length_m=sheet.free_length_m,
            mass_per_length_kg_per_m=self.mass_per_length_kg_per_m.value,
            material=Viscoelasticity(
                B_Nm2=B_Nm2,
                shares=tuple(term.share.value for term in self.prony),
                times_s=tuple(term.time_s.value for term in self.prony),
                viscous_time_s=self.viscous_time_s.value,
            ),
            rest=rest,
            fluid=around,
            elongation=Elongation(
                length_m=sheet.elongation_m,
                mass_per_length_kg_per_m=mass.value if mass else 0.0,
                fluid=around,
            ),
            electrodes=ElectrodeLine(
                electrode_ohm_per_m=self.electrode_ohm_per_m.value,
                capacitance_F_per_m=self.capacitance_F_per_m.value,
                bulk_ohm_m=self.bulk_ohm_m.value,
                leak_S_per_m=self.leak_S_per_m.value,
                source_ohm=self.source_ohm.value,
            ),
            moment_per_volt_Nm=(self.moment_per_volt_Nm[0].value, self.moment_per_volt_Nm[1].value),
        )

    def rolls(self, sheet: SheetGeometry, position_m: float) -> ContactSetup:
        """Return the load cell at a position on the arc."""
        cell = self.load_cell
        return ContactSetup(
            radius_m=sheet.arc_radius_m,
            position_m=position_m,
            origin_rad=sheet.arc_origin_rad,
            resonance_hz=cell.resonance_hz.value if cell else math.inf,
            damping=cell.damping.value if cell else 0.0,
        )

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""

        def entry(key: str, parameter: Parameter) -> dict[str, Any]:
            by = self.determined_by.get(key)
            return parameter.to_dict() | ({"determined_by": by} if by else {})

        names = [*_POSITIVE, *_NOT_NEGATIVE]
        if self.elongation_mass_kg_per_m is not None:
            names.append("elongation_mass_kg_per_m")
        table: dict[str, Any] = {name: entry(name, getattr(self, name)) for name in names}
        positive, negative = self.moment_per_volt_Nm
        table["moment_per_volt_Nm"] = {
            "positive": entry("moment_per_volt_Nm.positive", positive),
            "negative": entry("moment_per_volt_Nm.negative", negative),
        }
        table["prony"] = [
            {
                "share": entry(f"prony[{i}].share", term.share),
                "time_s": entry(f"prony[{i}].time_s", term.time_s),
            }
            for i, term in enumerate(self.prony)
        ]
        table["fluid"] = self.fluid
        if self.load_cell is not None:
            table["load_cell"] = {
                f.name: entry(f"load_cell.{f.name}", getattr(self.load_cell, f.name))
                for f in fields(self.load_cell)
            }
        return table

    @staticmethod
    def from_dict(data: object, where: str) -> DynamicSheet:
        """From a model file; errors name the place."""
        return _DynamicReader(where).read(data)


def fluid_around(name: str, width_m: float) -> FluidLoad:
    """Return the load of a fluid, one of FLUIDS, on a sheet of this width. Raises ModelError."""
    if name == "water":
        return fluid_load(width_m, 1000.0, 1e-3, WATER_FREQUENCY_HZ, drag_coefficient=2.0)
    if name == "air":
        return fluid_load(width_m, 1.2, 1.82e-5, AIR_FREQUENCY_HZ, drag_coefficient=2.0)
    if name == "vacuum":
        return VACUUM
    raise ModelError(f"'{name}' is no fluid that is known: one of {', '.join(FLUIDS)} is wanted")


class _DynamicReader:
    """Reads the tables of one configuration, and remembers what determined each number."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.determined_by: dict[str, str] = {}

    def read(self, data: object) -> DynamicSheet:
        table = self._table(data, "")
        known = {f.name for f in fields(DynamicSheet)} - {"determined_by"}
        unknown = sorted(set(table) - known)
        if unknown:
            raise ModelError(f"{self.where}: unknown key '{unknown[0]}'")
        numbers = {key: self._number(table, key, least="positive") for key in _POSITIVE}
        numbers |= {key: self._number(table, key, least="zero") for key in _NOT_NEGATIVE}
        mass = "elongation_mass_kg_per_m"
        alpha = self._table(table.get("moment_per_volt_Nm"), "moment_per_volt_Nm")
        fluid = table.get("fluid", "air")
        if fluid not in FLUIDS:
            raise ModelError(f"{self.where}.fluid: one of {', '.join(FLUIDS)} is wanted")
        return DynamicSheet(
            **numbers,
            moment_per_volt_Nm=(
                self._number(alpha, "positive", "moment_per_volt_Nm."),
                self._number(alpha, "negative", "moment_per_volt_Nm."),
            ),
            prony=self._prony(table.get("prony", [])),
            fluid=str(fluid),
            load_cell=self._load_cell(table.get("load_cell")),
            elongation_mass_kg_per_m=(
                self._number(table, mass, least="positive") if mass in table else None
            ),
            determined_by=self.determined_by,
        )

    def _prony(self, data: object) -> tuple[PronyTerm, ...]:
        if not isinstance(data, list):
            raise ModelError(f"{self.where}.prony: a list of tables is wanted")
        terms = []
        for i, one in enumerate(data):
            table, inside = self._table(one, f"prony[{i}]"), f"prony[{i}]."
            share = self._number(table, "share", inside, least="positive")
            time = self._number(table, "time_s", inside, least="positive")
            terms.append(PronyTerm(share=share, time_s=time))
        return tuple(terms)

    def _load_cell(self, data: object) -> LoadCellResonance | None:
        if data is None:
            return None
        table = self._table(data, "load_cell")
        return LoadCellResonance(
            resonance_hz=self._number(table, "resonance_hz", "load_cell.", least="positive"),
            damping=self._number(table, "damping", "load_cell.", least="zero"),
        )

    def _number(
        self, table: Mapping[str, Any], key: str, inside: str = "", least: str = ""
    ) -> Parameter:
        place = f"{self.where}.{inside}{key}"
        entry = table.get(key)
        if not isinstance(entry, dict):  # a bare number is exact
            entry = {"value": finite(entry, place)}
        found = Parameter.from_dict(entry, place)
        if least == "positive" and found.value <= 0.0:
            raise ModelError(f"{place}: must be positive, not {found.value:g}")
        if least == "zero" and found.value < 0.0:
            raise ModelError(f"{place}: must be zero or positive, not {found.value:g}")
        if "determined_by" in entry:
            self.determined_by[f"{inside}{key}"] = str(entry["determined_by"])
        return found

    def _table(self, data: object, key: str) -> dict[str, Any]:
        if not isinstance(data, dict):
            dot = "." if key else ""
            raise ModelError(f"{self.where}{dot}{key}: a table is wanted")
        return data

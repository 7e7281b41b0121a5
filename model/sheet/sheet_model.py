"""`SheetModel`: what a fit hands back, a sheet's parameters with their uncertainty; it predicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from model.dynamics import ContactSetup, DynamicBeam, DynamicSheet
from model.effects.between_sessions import sessions_in
from model.measurements import Displayed, FloatArray, ModelError, Summary
from model.measurements.checked_values import shown
from model.parameter import finite
from model.sheet.beam_problem import ActiveEffect, ConditionProblem
from model.sheet.configured_sheet import FITTED, ConfiguredSheet, FittedPositions, table
from model.sheet.deviations import Deviations

if TYPE_CHECKING:
    from model.sheet.prediction import Prediction
    from model.sheet.predictions import PredictionArray

# of a model file; the second where a labrig that knows the first would predict without something
FORMAT, WITH_FORMS = 1, 2


@dataclass(frozen=True, kw_only=True, repr=False)
class SheetModel(Displayed):
    """Geometry, parameters, active effects; what it was fitted to and how well."""

    sheets: Mapping[str, ConfiguredSheet]
    effects: tuple[ActiveEffect, ...] = ()
    source: str = ""  # the file it was fitted to
    checksum: str = ""  # sha256 of that file
    held_out: tuple[str, ...] = ()  # conditions that were left out
    merit: Mapping[str, float] = field(default_factory=dict)  # names with their unit; of all sheets
    # the same of each configuration alone, where the file states it
    own_merit: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    dynamic: Mapping[str, DynamicSheet] = field(default_factory=dict)  # by configuration
    # whose prediction is asked for, where effects differ between sessions; 0: their mean
    session: int = 0
    # free lengths as measured of sheets that are cut to another, to which their effects refer
    cut_from_m: Mapping[str, float] = field(default_factory=dict)
    # how the parameters of a configuration, with the effects', are uncertain together; a
    # configuration that is not here: each by itself
    deviations: Mapping[str, Deviations] = field(default_factory=dict)
    fitted: Mapping[str, FittedPositions] = field(default_factory=dict)  # by configuration

    def summary(self) -> Summary:
        """Return the parameters of each configuration, and the names of the effects."""
        rows = [(name, *row) for name, one in self.sheets.items() for row in one.summary().rows]
        origin = f" fitted to {self.source}" if self.source else ""
        merit = ", ".join(f"{name} {value:.3g}" for name, value in self.merit.items())
        notes = (
            *([f"effects: {', '.join(one.name for one in self.effects)}"] if self.effects else []),
            *([f"in time: {', '.join(self.dynamic)}"] if self.dynamic else []),
            *([f"errors: {merit}"] if merit else []),
        )
        columns = ("sheet", "parameter", "value", "sigma", "unit")
        return Summary(f"SheetModel{origin}: {', '.join(self.sheets)}", columns, rows, notes)

    def sheet(self, configuration: str) -> ConfiguredSheet:
        """Return a configuration's parameters."""
        if not self.sheets:
            raise ModelError("this model has no configuration: nothing was fitted")
        if not isinstance(configuration, str) or configuration not in self.sheets:
            known = ", ".join(sorted(self.sheets))
            raise ModelError(f"the model has no configuration '{configuration}' (it has: {known})")
        return self.sheets[configuration]

    def moving(
        self, configuration: str, position_m: float | None
    ) -> tuple[DynamicBeam, ContactSetup | None]:
        """Return a configuration in time and the rolls at a position, for `dynamics.simulate`.

        Effects are not included. Raises ModelError where the file says nothing of the dynamics.
        """
        one = self.sheet(configuration)
        if configuration not in self.dynamic:
            raise ModelError(
                f"the model of '{configuration}' has no table 'dynamic': mass, loss and electrodes"
                " are not known"
            )
        dynamic, sheet = self.dynamic[configuration], one.sheet
        beam = dynamic.beam(sheet, one.B.value, one.rest.field(sheet.free_length_m))
        if position_m is None:
            return beam, None
        return beam, dynamic.rolls(sheet, position_m)

    def setup(
        self, configuration: str, position_m: float | None, voltage_V: float
    ) -> ConditionProblem:
        """Return a condition's beam problem with effects; no contact without a position."""
        volts = (
            self.alternating_voltages_V(configuration, voltage_V) if self.effects else (voltage_V,)
        )
        return self.setups(configuration, [(position_m, v) for v in volts])[0]

    def setups(
        self, configuration: str, places: Sequence[tuple[float | None, float]]
    ) -> list[ConditionProblem]:
        """Beam problems of conditions, given by position and voltage, effects included."""
        plain = self._plain(configuration, places)
        if not self.effects:
            return plain
        from model.sheet.applied_effects import with_effects

        return with_effects(plain, [position for position, _ in places], self.effects)

    def alternating_voltages_V(self, configuration: str, voltage_V: float) -> tuple[float, ...]:
        """Return a voltage and those it alternates with in a run: 0 V and the other polarity."""
        known = [0.0, *self.sheet(configuration).eibm]
        opposite = float(np.clip(-voltage_V, min(known), max(known)))
        if voltage_V == 0.0:
            return (0.0, *(v for v in (max(known), min(known)) if v))
        return tuple(dict.fromkeys((float(voltage_V), 0.0, opposite)))

    def beyond(self, configuration: str, position_m: float) -> str:
        """Return a remark on a position that lies outside those fitted; else nothing."""
        fitted = self.fitted.get(configuration)
        return fitted.beyond(position_m) if fitted is not None else ""

    def _plain(
        self, configuration: str, places: Sequence[tuple[float | None, float]]
    ) -> list[ConditionProblem]:
        """Return beam problems without effects; those of one voltage share its field."""
        one = self.sheet(configuration)
        R, origin = one.sheet.arc_radius_m, one.sheet.arc_origin_rad
        rest, eibm, result = one.rest.field(one.sheet.free_length_m), {}, []
        for position_m, voltage_V in places:
            along = np.nan if position_m is None else position_m / R
            if (position_m is not None and not isfinite(position_m)) or not isfinite(voltage_V):
                raise ModelError("position and voltage must be finite numbers")
            if voltage_V not in eibm:
                eibm[voltage_V] = one.eibm_at(voltage_V)
            result.append(
                ConditionProblem(
                    sheet=one.sheet, voltage_V=voltage_V, angle_rad=origin + along,
                    B_Nm2=one.B.value, rest=rest, eibm=eibm[voltage_V], session=self.session,
                    measured_length_m=self.cut_from_m.get(configuration, 0.0),
                )
            )  # fmt: skip
        return result

    @overload
    def predict(self, configuration: str, position_m: float, voltage_V: float) -> Prediction: ...

    @overload
    def predict(
        self, configuration: str, position_m: npt.ArrayLike, voltage_V: npt.ArrayLike
    ) -> PredictionArray: ...

    def predict(
        self, configuration: str, position_m: npt.ArrayLike, voltage_V: npt.ArrayLike
    ) -> Prediction | PredictionArray:
        """Predict force and shape of a condition, or of arrays of conditions in one batch.

        configuration: name of one of the model's sheets. position_m: along the arc in m;
        voltage_V: within the voltages of the model. Two numbers give a `Prediction`; arrays are
        broadcast and give `PredictionArray`. A position that is not reachable is no error.

        Raises ModelError for an unknown configuration or voltage, and for what is no number.
        """
        from model.sheet.prediction import predict
        from model.sheet.predictions import predict_array

        positions, volts = _numbers("position_m", position_m), _numbers("voltage_V", voltage_V)
        if positions.ndim == volts.ndim == 0:
            return predict(self, configuration, float(positions), float(volts))
        return predict_array(self, configuration, positions, volts)

    def with_effects(self, *effects: ActiveEffect) -> SheetModel:
        """Return the same model with these effects."""
        return replace(self, effects=effects, deviations={})

    @property
    def sessions(self) -> int:
        """How many sessions its effects tell apart; 0: none differs between sessions."""
        values = (v for e in self.effects for v in (e.parameters, *e.by_configuration.values()))
        return max(map(sessions_in, values), default=0)

    def in_session(self, number: int) -> SheetModel:
        """Return the same model as it was in one of the sessions that it was fitted to."""
        return replace(self, session=number)

    def with_merit(
        self, merit: Mapping[str, float], own: Mapping[str, Mapping[str, float]]
    ) -> SheetModel:
        """Return the same model with its errors, and those of each configuration."""
        return replace(self, merit=merit, own_merit={n: one for n, one in own.items() if one})

    def to_dict(self) -> dict[str, Any]:
        """Plain tables for a model file."""
        return {
            "labrig_model": WITH_FORMS
            if any(e.form or e.across_curve for e in self.effects)
            else FORMAT,
            "fitted_to": {
                "file": self.source, "sha256": self.checksum, "held_out": list(self.held_out)
            },
            "figures_of_merit": dict(self.merit),
            "configurations": {
                name: one.to_dict()
                | _merit_to_dict(self.own_merit.get(name, {}))
                | {
                    key: parts[name].to_dict()
                    for key, parts in self._parts()
                    if name in parts
                }
                for name, one in self.sheets.items()
            },
            "effects": [e.to_dict() for e in self.effects],
        }  # fmt: skip

    def _parts(self) -> tuple[tuple[str, Mapping[str, Any]], ...]:
        """Return what a configuration's table may have, by its key."""
        return (
            (FITTED, self.fitted),
            ("deviations", self.deviations),
            ("dynamic", self.dynamic),
        )

    @staticmethod
    def from_dict(data: object) -> SheetModel:
        """From the tables of a model file; errors name the key."""
        version = data.get("labrig_model") if isinstance(data, dict) else None
        if type(version) is int and version > WITH_FORMS:
            raise ModelError(
                f"the model file has format {version} and this labrig reads formats {FORMAT} and "
                f"{WITH_FORMS}; use a newer labrig"
            )
        if not isinstance(data, dict) or version not in (FORMAT, WITH_FORMS):
            raise ModelError(
                f"this is not a model file of format {FORMAT} or {WITH_FORMS} (key labrig_model)"
            )
        sheets = table(data, "configurations")
        fitted = data.get("fitted_to", {})
        if not isinstance(fitted, dict):
            raise ModelError("fitted_to: a table is wanted")
        effects = data.get("effects", [])
        if not isinstance(effects, list):
            raise ModelError("effects: a list of tables is wanted")
        known = {name: ConfiguredSheet.from_dict(name, one) for name, one in sheets.items()}
        own = {name: _merit(one, f"configurations.{name}.") for name, one in sheets.items()}
        fitted_m = {
            name: FittedPositions.from_dict(one, f"configurations.{name}")
            for name, one in sheets.items()
        }
        return SheetModel(
            sheets=known,
            effects=tuple(
                ActiveEffect.from_dict(e, f"effects[{i}]") for i, e in enumerate(effects)
            ),
            source=str(fitted.get("file", "")), checksum=str(fitted.get("sha256", "")),
            held_out=tuple(str(c) for c in fitted.get("held_out", [])),
            fitted={name: one for name, one in fitted_m.items() if one is not None},
            merit=_merit(data), own_merit={name: merit for name, merit in own.items() if merit},
            dynamic={
                name: DynamicSheet.from_dict(one["dynamic"], f"configurations.{name}.dynamic")
                for name, one in sheets.items()
                if "dynamic" in one
            },
            deviations={
                name: Deviations.from_dict(one["deviations"], f"configurations.{name}.deviations")
                for name, one in sheets.items()
                if "deviations" in one
            },
        )  # fmt: skip


def _numbers(name: str, given: npt.ArrayLike) -> FloatArray:
    """Return a number or an array of them. Raises ModelError, which names the argument."""
    try:
        found = np.asarray(given)
        # NumPy would take the text of a number, half of a complex one, and what a mask hides
        if found.dtype.kind in "USc" or np.ma.is_masked(given):
            raise TypeError
        return found.astype(np.float64)
    except (TypeError, ValueError):  # also rows of different lengths
        raise ModelError(
            f"{name} {shown(given)}: a number or an array of numbers is needed"
        ) from None


def _merit(data: dict[str, Any], where: str = "") -> dict[str, float]:
    """Return the figures of merit of a model file or of one of its configurations."""
    merit = data.get("figures_of_merit", {})
    if not isinstance(merit, dict):
        raise ModelError(f"{where}figures_of_merit: a table is wanted")
    return {str(k): finite(v, f"{where}figures_of_merit.{k}") for k, v in merit.items()}


def _merit_to_dict(merit: Mapping[str, float]) -> dict[str, Any]:
    return {"figures_of_merit": dict(merit)} if merit else {}

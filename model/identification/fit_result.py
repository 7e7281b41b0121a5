"""What `fit` finds: parameters of each configuration, models, residuals and errors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from model.identification.joint import Joint
from model.identification.options import FitOptions
from model.identification.paper import PaperFit
from model.identification.residuals import ConditionResidual, Rmse
from model.measurements import (
    Displayed,
    FloatArray,
    ModelError,
    Summary,
    dataframe,
    in_decimals,
)
from model.measurements.columns import of_rows
from model.parameter import Parameter
from model.sheet import misfit
from model.sheet.sheet_model import SheetModel

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, kw_only=True, repr=False)
class ConfigurationFit(Displayed):
    """One configuration's Tables 4 and 6 and figure 8."""

    configuration: str
    B: Parameter
    B_per_width: Parameter
    E: Parameter
    eibm: dict[float, Parameter]  # constant EIBM by voltage, (9)
    eibm_mean: dict[float, Parameter]  # mean over [0, l] of the EIBM along the sheet
    eibm_mean_abs: Parameter  # mean absolute value over the voltages
    eibm_mean_abs_per_width: Parameter
    s_m: FloatArray
    eibm_along_Nm: dict[float, tuple[FloatArray, FloatArray]]  # by voltage: Me(s), sigma
    rest_per_m: FloatArray  # k0 at s_m as the model uses it
    rest_measured_per_m: FloatArray  # k0 at s_m as the shapes have it
    rmse: dict[Literal["constant", "varying"], Rmse]
    paper: PaperFit | None  # (7)-(9) condition by condition; None without curves
    B_known: bool = True  # False: no force was measured, and B is as it was stated, not estimated

    def parameters(self) -> dict[str, Parameter]:
        """Return the fitted parameters, by name and in SI units."""
        return {
            **({"B": self.B, "B_per_width": self.B_per_width, "E": self.E} if self.B_known else {}),
            **{f"EIBM_{v:+g}V": p for v, p in self.eibm.items()},
            "mean_abs_EIBM": self.eibm_mean_abs,
            "mean_abs_EIBM_per_width": self.eibm_mean_abs_per_width,
            **{f"EIBM_along_mean_{v:+g}V": p for v, p in self.eibm_mean.items()},
        }

    def summary(self) -> Summary:
        """Return the parameters with their 90 % intervals, and the errors."""
        rows = [
            (name, f"{p.value:.4g}", *(f"{end:.4g}" for end in p.interval()), p.unit)
            for name, p in self.parameters().items()
        ]
        notes = tuple(
            f"{kind} EIBM, RMS error: force {in_decimals(1e3 * one.force_N, 3)} mN, neutral curve "
            f"{in_decimals(1e3 * one.curve_m, 3)} mm"
            for kind, one in self.rmse.items()
        )
        columns = ("parameter", "value", "90 % from", "to", "unit")
        return Summary(f"ConfigurationFit '{self.configuration}'", columns, rows, notes)

    @property
    def eibm_over_B(self) -> dict[float, Parameter]:
        """The constant EIBM over B by voltage, 1/m: what shapes alone determine."""
        return {v: p.scaled(1.0 / self.B.value, "1/m") for v, p in self.eibm.items()}


@dataclass(frozen=True, kw_only=True, repr=False)
class Fit(Displayed):
    """Outcome of `fit`."""

    model: SheetModel  # constant EIBM: the base model
    varying_model: SheetModel  # EIBM along the sheet
    configurations: dict[str, ConfigurationFit]
    residuals: tuple[ConditionResidual, ...]
    rmse: dict[Literal["constant", "varying"], Rmse]  # all configurations
    scatter: dict[str, float]  # from one set-up to the next, by random effect
    noise: dict[str, float]
    bootstrap_ratio: dict[str, float]  # simulated over stated uncertainty, where asked for
    notes: tuple[str, ...]
    options: FitOptions
    joint: Joint

    def summary(self) -> Summary:
        """Return B and the constant EIBMs with their 90 % intervals, and the errors."""
        rows = [
            (name, what, f"{p.value:.4g}", *(f"{end:.4g}" for end in p.interval()), p.unit)
            for name, one in self.configurations.items()
            for what, p in one.parameters().items()
            if what in ("B", "E") or what.startswith("EIBM_")
        ]
        errors = tuple(
            f"{kind} EIBM, RMS error: force {in_decimals(1e3 * one.force_N, 3)} mN, neutral curve "
            f"{in_decimals(1e3 * one.curve_m, 3)} mm"
            for kind, one in self.rmse.items()
        )
        columns = ("sheet", "parameter", "value", "90 % from", "to", "unit")
        origin = f" of {self.model.source}" if self.model.source else ""
        return Summary(f"Fit{origin}", columns, rows, (*errors, *self.notes))

    def to_dataframe(self, part: Literal["parameters", "residuals"] = "parameters") -> pd.DataFrame:
        """Return a part of the fit as a pandas data frame, in SI units.

        part: `parameters` (a row for each, with its standard uncertainty and 90 % interval) or
        `residuals` (a row for each condition: measured and simulated force, error of the curve).

        Raises ModelError for another part, MissingPandasError where pandas is not installed.
        """
        if part == "parameters":
            return dataframe(of_rows(list(self._parameter_rows())))
        if part == "residuals":
            return dataframe(of_rows([_residual_row(one) for one in self.residuals]))
        raise ModelError(f"a fit has no part '{part}', but parameters, residuals")

    def _parameter_rows(self) -> Iterator[dict[str, Any]]:
        for name, one in self.configurations.items():
            for what, p in one.parameters().items():
                low, high = p.interval()
                yield {
                    "configuration": name, "parameter": what, "value": p.value, "sigma": p.sigma,
                    "low90": low, "high90": high, "unit": p.unit,
                }  # fmt: skip

    @property
    def preferred_model(self) -> SheetModel:
        """The model with constant EIBM, unless it misses what the one along the sheet does not."""
        missed = any(misfit.misfit(self.model, name).misses for name in self.configurations)
        return self.varying_model if missed else self.model

    def to_json(self) -> dict[str, Any]:
        """For `fit --json`."""
        constant = self.rmse["constant"]
        return {
            "configurations": {n: _to_json(one) for n, one in self.configurations.items()},
            "rmse": {"force_mN": constant.force_N * 1e3, "curve_mm": constant.curve_m * 1e3},
        }


def _residual_row(one: ConditionResidual) -> dict[str, Any]:
    return {
        "configuration": one.configuration, "position_m": one.position_m,
        "voltage_V": one.voltage_V, "force_N": one.force_N, "force_sigma_N": one.force_sigma_N,
        **{f"predicted_{kind}_N": value for kind, value in one.predicted_N.items()},
        **{f"curve_rmse_{kind}_m": value for kind, value in one.curve_rmse_m.items()},
    }  # fmt: skip


def _to_json(one: ConfigurationFit) -> dict[str, Any]:
    stiffness: dict[str, Any] = {"B_Nm2": one.B.to_json(), "E_Pa": one.E.to_json()}
    if not one.B_known:
        ratio = {str(float(v)): p.to_json() for v, p in one.eibm_over_B.items()}
        stiffness = {
            "B_Nm2": None, "E_Pa": None, "B_taken_Nm2": one.B.value, "EIBM_over_B_per_m": ratio
        }  # fmt: skip
    return {
        **stiffness,
        "EIBM_Nm": {str(float(v)): p.to_json() for v, p in one.eibm.items()},
        "EIBM_along_sheet": {
            str(float(v)): {
                "s_mm": (one.s_m * 1e3).tolist(), "Me_Nm": values.tolist(), "sigma": sigma.tolist()
            }
            for v, (values, sigma) in one.eibm_along_Nm.items()
        },
    }  # fmt: skip

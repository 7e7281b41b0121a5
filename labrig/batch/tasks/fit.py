"""Fit each session or table by itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from labrig.batch.contract import BatchAnswer, BatchItem, BatchTask, InputKind, option
from labrig.batch.tasks._measured import (
    MEASURES,
    columns_about,
    columns_of,
    columns_option,
    fit_something,
    ignore_option,
    measurements_of,
    values_option,
)


@dataclass(frozen=True, kw_only=True)
class FitEach(BatchTask):
    """Fit each session, or each sheet.toml with its tables.

    It is what labrig fit does. A row has B and EIBM of each configuration and the errors;
    each/NAME.json what fit --json prints and each/NAME.toml the model that fit -o writes. Sessions
    that were not analysed yet are analysed, and keep their measurements.
    """

    takes = frozenset({InputKind.SESSION, InputKind.TABLES})
    measures = MEASURES

    symmetric: bool = option("one |EIBM| for both polarities", default=False)
    measured_curvature: bool = option(
        "k0 from the curves at 0 V, whatever sheet.toml states", default=False
    )
    q: float = option("weight exponent q of (7)", default=1.0)
    stiffness_Nm2: float | None = option(
        "B of sheets that no force was measured of", default=None, flag="--stiffness-Nm2"
    )
    columns: tuple[str, ...] = columns_option()
    values: tuple[str, ...] = values_option()
    ignore: tuple[str, ...] = ignore_option()

    def check(self) -> None:
        """See `BatchTask.check`."""
        from labrig.session import column_names

        column_names(self.columns, self.values, self.ignore)

    def warm_up(self) -> None:
        """See `BatchTask.warm_up`."""
        fit_something()

    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        """See `BatchTask.work`."""
        from labrig.errors import BadInputError
        from labrig.model_file import model_text
        from labrig.report.data.fitted import fit_what_can_be
        from model import FitOptions

        del folder
        options = FitOptions(
            symmetric=self.symmetric,
            measured_curvature=self.measured_curvature,
            weight_exponent=self.q,
            stiffness_Nm2=self.stiffness_Nm2,
        )
        measurements = measurements_of(item.source, self.columns, self.values, self.ignore)
        fitted = fit_what_can_be(measurements, options)
        if fitted.fit is None:
            why = "; ".join(dict.fromkeys(fitted.missing.values())) or "nothing was measured"
            raise BadInputError(f"{item.source.path}: no configuration can be fitted: {why}.")
        found = fitted.fit
        errors = {}
        for name, one in found.configurations.items():
            for kind, rmse in one.rmse.items():
                errors[f"rmse_force_N[{name}, {kind}]"] = rmse.force_N
                errors[f"rmse_curve_m[{name}, {kind}]"] = rmse.curve_m
        columns = {
            **columns_about(item.source),
            **columns_of(found.model, measurements, self.stiffness_Nm2),
            **errors,
            "not_fitted": sorted(fitted.missing),
        }
        files = {"toml": model_text(found.preferred_model)}
        return BatchAnswer(columns=columns, whole=found.to_json(), files=files)


TASK = FitEach

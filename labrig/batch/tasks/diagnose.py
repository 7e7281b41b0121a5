"""Diagnose each session or table by itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.batch.contract import BatchAnswer, BatchItem, BatchTask, InputKind, option
from labrig.batch.tasks._measured import (
    MEASURES,
    columns_about,
    columns_of,
    columns_option,
    diagnose_something,
    ignore_option,
    measurements_of,
    values_option,
)

if TYPE_CHECKING:
    from model.discrepancy import Diagnosis


@dataclass(frozen=True, kw_only=True)
class DiagnoseEach(BatchTask):
    """Diagnose each session, or each sheet.toml with its tables.

    It is what labrig diagnose does. A row has the verdict, the effects named, and B and EIBM of the
    base model; each/NAME.json the whole diagnosis and each/NAME.toml the model with its effects.
    Sessions that were not analysed yet are analysed, and keep their measurements; the diagnosis
    itself is not stored in them.
    """

    takes = frozenset({InputKind.SESSION, InputKind.TABLES})
    measures = MEASURES
    counted = ("verdict", "effects")

    symmetric: bool = option(
        "one |EIBM| for both polarities: asymmetry is a finding", default=False
    )
    without: tuple[str, ...] = option(
        "an effect that is known to be absent; repeatable", default=(), metavar="EFFECT"
    )
    calibrate: int = option(
        "number of simulated sessions for the threshold", default=0, min=0, max=10_000
    )
    most_effects: int | None = option(
        "names to look for, 3 by default; more may take minutes", default=None, min=1, max=10
    )
    model: Path | None = option("a model file whose effects are known", default=None)
    stiffness_Nm2: float | None = option(
        "B of sheets that no force was measured of", default=None, flag="--stiffness-Nm2"
    )
    columns: tuple[str, ...] = columns_option()
    values: tuple[str, ...] = values_option()
    ignore: tuple[str, ...] = ignore_option()

    def check(self) -> None:
        """See `BatchTask.check`."""
        from labrig.session import column_names
        from model.effects import effect

        column_names(self.columns, self.values, self.ignore)
        for name in self.without:
            effect(name)
        if self.model is not None:
            from labrig.model_file import load_model

            load_model(self.model)

    def version(self) -> str:
        """See `BatchTask.version`."""
        from model.effects.catalogue import FOLDER
        from model.locations.catalogue import FOLDER as LOCATIONS

        parts = {**FOLDER.origins(), **LOCATIONS.origins()}
        origins = sorted(f"{name} {origin}" for name, origin in parts.items())
        return ", ".join([super().version(), *origins])

    def warm_up(self) -> None:
        """See `BatchTask.warm_up`."""
        diagnose_something()

    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        """See `BatchTask.work`."""
        from labrig.analysis.driven import require_driven
        from labrig.model_file import load_model, model_text
        from model.discrepancy import DiagnoseOptions, diagnose
        from model.discrepancy.thresholds import MOST_EFFECTS

        del folder
        measurements = measurements_of(item.source, self.columns, self.values, self.ignore)
        require_driven(measurements)
        known = None if self.model is None else load_model(self.model)
        options = DiagnoseOptions(
            symmetric=self.symmetric,
            calibrate=self.calibrate,
            most_effects=MOST_EFFECTS if self.most_effects is None else self.most_effects,
            exclude=self.without,
            model=known,
            stiffness_Nm2=self.stiffness_Nm2,
        )
        found = diagnose(measurements, options)
        files = {"toml": model_text(found.model)} if found.searched else {}
        columns = {
            **columns_about(item.source),
            **_columns(found),
            **columns_of(found.model, measurements, self.stiffness_Nm2),
            "sentence": found.sentence,
        }
        return BatchAnswer(columns=columns, whole=found.to_json(), files=files)


def _columns(found: Diagnosis) -> dict[str, Any]:
    unknown = found.unknown
    return {
        "verdict": found.verdict,
        "effects": [one.name for one in found.effects],
        "confidence": min((one.confidence for one in found.effects), default=None),
        "unknown": None if unknown is None else unknown.location,
        "gap_closed": found.closed,
        "chi2_per_dof": found.fitted.before.chi2_per_dof,
        "suspicions": len(found.data_checks),
    }


TASK = DiagnoseEach

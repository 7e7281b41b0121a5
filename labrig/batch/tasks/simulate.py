"""Simulate sessions of a model and fit them: how often the stated intervals hold the truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.batch.contract import (
    BatchAnswer,
    BatchInput,
    BatchItem,
    BatchTask,
    InputKind,
    Measure,
    option,
)
from labrig.batch.tasks._measured import fit_something

if TYPE_CHECKING:
    from model import Fit, Parameter, SheetModel

_MILLI = 1e-3


@dataclass(frozen=True, kw_only=True)
class CoverageStudy(BatchTask):
    """Count how often the intervals of a fit hold the truth.

    Sessions are drawn from a model file, and each is fitted.

    The sessions are of the model's own sheets, at 0 V and its voltages, with the noise that is
    stated and no scatter from set-up to set-up. A row is a session: whether the 90 % interval of B
    and of each EIBM holds the model's value, and by how many sigma it is off. An EIBM that varies
    along the model's sheet is replaced by its mean.
    """

    takes = frozenset({InputKind.MODEL})
    measures = (Measure(column="error_sigma", title="error", unit="sigma"),)
    counted = ("holds",)

    count: int = option("sessions of each model", default=100, min=1, max=10_000_000)
    seed: int = option("of the first session", default=0, min=0)
    position_mm: tuple[float, ...] = option(
        "along the arc; repeatable; default 0, 10, 20, 30", default=(0.0, 10.0, 20.0, 30.0)
    )
    readings: int = option("of each voltage at each position", default=10, min=1, max=1000)
    force_noise_mN: float = option("of a reading", default=0.02, flag="--force-noise-mN", min=0.0)
    curve_noise_mm: float = option("of each point of a curve", default=0.002, min=0.0)

    def items(self, source: BatchInput) -> Iterator[BatchItem]:
        """See `BatchTask.items`."""
        for seed in range(self.seed, self.seed + self.count):
            yield BatchItem(source=source, part={"seed": seed}, label=f"seed {seed}")

    def warm_up(self) -> None:
        """See `BatchTask.warm_up`."""
        fit_something()

    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        """See `BatchTask.work`."""
        from labrig.batch.tasks._simulated import Simulated, simulated
        from labrig.model_file import load_model
        from model import fit

        del folder
        truth = _constant(load_model(item.source.path))
        wanted = Simulated(
            positions_m=tuple(_MILLI * place for place in self.position_mm),
            readings=self.readings,
            force_noise_N=_MILLI * self.force_noise_mN,
            curve_noise_m=_MILLI * self.curve_noise_mm,
            seed=item.part["seed"],
        )
        found = fit(simulated(truth, wanted))
        columns: dict[str, Any] = {"seed": item.part["seed"]}
        for name, (estimate, true) in _compared(found, truth).items():
            low, high = estimate.interval()
            columns[f"true[{name}]"] = true
            columns[f"found[{name}]"] = estimate.value
            columns[f"error_sigma[{name}]"] = (estimate.value - true) / estimate.sigma
            columns[f"holds[{name}]"] = low <= true <= high
        return BatchAnswer(columns=columns, whole=found.to_json())


def _constant(model: SheetModel) -> SheetModel:
    """Return the model without effects, each EIBM as its mean."""
    from dataclasses import replace

    from model import Along, Parameter

    sheets = {
        name: replace(
            one,
            eibm={
                volts: Along.constant(Parameter(value=one.mean_eibm(volts), sigma=0.0, unit="N m"))
                for volts in one.eibm
            },
        )
        for name, one in model.sheets.items()
    }
    return replace(model, sheets=sheets, effects=())


def _compared(found: Fit, truth: SheetModel) -> dict[str, tuple[Parameter, float]]:
    pairs: dict[str, tuple[Parameter, float]] = {}
    for name, one in found.configurations.items():
        own = truth.sheets[name]
        pairs[f"B, {name}"] = (one.B, own.B.value)
        for volts, estimate in sorted(one.eibm.items()):
            pairs[f"EIBM, {name}, {volts:+g} V"] = (estimate, own.mean_eibm(volts))
    return pairs


TASK = CoverageStudy

"""A task that costs nothing, and the plan of a batch of them or of simulated sessions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from labrig.batch import BatchAnswer, BatchInput, BatchItem, BatchTask, InputKind, option
from labrig.batch.plan import BatchOrder, BatchPlan, plan
from labrig.model_file import save_model
from model import Along, ConfiguredSheet, Parameter, SheetGeometry, SheetModel


@dataclass(frozen=True, kw_only=True)
class Costless(BatchTask):
    """Do nothing, many times."""

    takes = frozenset({InputKind.MODEL})
    counted = ("even",)

    count: int = option("pieces", default=10)

    def items(self, source: BatchInput) -> Iterator[BatchItem]:
        for k in range(self.count):
            yield BatchItem(source=source, part={"k": k}, label=f"piece {k}")

    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        del folder
        k = item.part["k"]
        return BatchAnswer(columns={"k": k, "even": k % 2 == 0}, whole={"k": k})


def planned(task: BatchTask, model: Path, output: Path) -> BatchPlan:
    """All pieces of a model file."""
    source = BatchInput(InputKind.MODEL, model, model.name)
    return plan(BatchOrder(name=type(task).__name__, task=task, inputs=[source], output=output))


def write_model(path: Path) -> Path:
    """A sheet as in the paper, with constant EIBM."""
    import numpy as np

    sheet = SheetGeometry(
        configuration="long", free_length_m=0.05, width_m=0.011, thickness_m=2e-4,
        elongation_m=0.0, arc_radius_m=0.04, arc_origin_rad=0.0,
        initial_curvature=(np.zeros(1), np.zeros(1)),
    )  # fmt: skip
    rest = Along(np.zeros(1), np.zeros(1), np.zeros(1), "1/m")
    eibm = {
        volts: Along.constant(Parameter(value=moment, sigma=0.0, unit="N m"))
        for volts, moment in ((2.0, 3e-5), (-2.0, -2.5e-5))
    }
    one = ConfiguredSheet(sheet, Parameter(value=1.2e-6, sigma=0.0, unit="N m^2"), rest, eibm)
    save_model(SheetModel(sheets={"long": one}), path)
    return path

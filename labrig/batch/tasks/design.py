"""Answer the design questions for each model, over a grid of what is wanted."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
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
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from labrig.report.design.answers import DesignAnswers

_DIRECTIONS = ("both", "positive", "negative")
_MILLI = 1e-3


@dataclass(frozen=True, kw_only=True)
class DesignSweep(BatchTask):
    """Answer the design questions for many models and sections.

    They are those of labrig design. A row is one combination: a model, one of its configurations, a
    working section, a force and a direction. It has the least area, the shortest length, the
    largest forces and the best line.
    """

    takes = frozenset({InputKind.MODEL})
    measures = (
        Measure(column="least_area_m2", title="least area", unit="mm²", scale=1e6),
        Measure(column="largest_force_N", title="largest force", unit="mN", scale=1e3),
    )
    counted = ("unanswered",)

    section: tuple[str, ...] = option(
        "a working section in mm; repeatable; default 0:30", default=("0:30",), metavar="LOW:HIGH"
    )
    force_mN: tuple[float, ...] = option(
        "required throughout: the least area for it; repeatable", default=(), flag="--force-mN"
    )
    direction: tuple[str, ...] = option(
        "both, positive or negative: of the required force; repeatable; default both",
        default=("both",),
    )
    mass_g: float = option("of the object on the arc", default=1.0, min=0.0)
    bandwidth_hz: float = option(
        "wanted of the controlled object", default=1.0, min=0.0, flag="--bandwidth-hz"
    )
    lag_s: float = option("of the voltage's effect", default=0.0, min=0.0)

    def check(self) -> None:
        """See `BatchTask.check`."""
        from labrig.api.design import section_m

        for text in self.section:
            section_m(text)
        for force_mN in self.force_mN:
            if not 0.0 < force_mN < math.inf:
                raise BadInputError(f"--force-mN {force_mN:g}: a number above 0 is needed.")
        for one in self.direction:
            if one not in _DIRECTIONS:
                raise BadInputError(f"--direction {one}: give {', '.join(_DIRECTIONS)}.")

    def items(self, source: BatchInput) -> Iterator[BatchItem]:
        """See `BatchTask.items`."""
        from labrig.model_file import load_model

        names = load_model(source.path).sheets
        forces: tuple[float | None, ...] = self.force_mN or (None,)
        for name, section, force_mN, way in product(names, self.section, forces, self.direction):
            words = [name, f"{section} mm"]
            if force_mN is not None:
                words += [f"{force_mN:g} mN", way]
            part = {
                "configuration": name, "section": section, "force_mN": force_mN, "direction": way,
            }  # fmt: skip
            yield BatchItem(source=source, part=part, label=" ".join(words))

    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        """See `BatchTask.work`."""
        from labrig.api.design import section_m
        from labrig.model_file import load_model
        from labrig.report.design.answers import Wanted, answer, as_dict
        from model.sheet.misfit import misfit

        del folder
        model, part = load_model(item.source.path), item.part
        low_m, high_m = section_m(part["section"])
        force_mN = part["force_mN"]
        wanted = Wanted(
            configuration=part["configuration"],
            low_m=low_m,
            high_m=high_m,
            force_N=None if force_mN is None else _MILLI * force_mN,
            direction=part["direction"],
            mass_kg=_MILLI * self.mass_g,
            bandwidth_rad_per_s=2.0 * math.pi * self.bandwidth_hz,
            lag_s=self.lag_s,
        )
        found = answer(model, wanted)
        columns = {**part, **_columns(found)}
        return BatchAnswer(
            columns=columns, whole=as_dict(found, misfit(model, wanted.configuration))
        )


def _columns(found: DesignAnswers) -> dict[str, Any]:
    columns: dict[str, Any] = {}
    for name, size in found.sizes.items():
        columns[f"least_area_m2[{name}]"] = size.area_m2.value
        columns[f"length_m[{name}]"] = size.length_m
        columns[f"width_m[{name}]"] = size.width_m.value
    for direction, force in found.largest.items():
        columns[f"largest_force_N[{direction}]"] = force.force_N.value
    for line in found.lines:
        columns[f"line_error_N[{line.voltage_V:+g} V]"] = line.rms_error_N.value
    columns["shortest_length_m"] = None if found.reach is None else found.reach.length_m.value
    both = found.both_ways
    columns["force_both_ways_N"] = None if both is None else both.force_N.value
    columns["unanswered"] = sorted(found.unanswered)
    return columns


TASK = DesignSweep

"""Analyse each session."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from labrig.batch.contract import BatchAnswer, BatchItem, BatchTask, InputKind, option


@dataclass(frozen=True, kw_only=True)
class AnalyzeEach(BatchTask):
    """Measure forces and neutral curves of each session.

    Each session keeps its own, as with labrig analyze. A row has the number of conditions, readings
    and curves, and the warnings.
    """

    takes = frozenset({InputKind.SESSION})

    extractor: str | None = option(
        "name of a curve extractor; default: the built-in one", default=None
    )

    def check(self) -> None:
        """See `BatchTask.check`."""
        if self.extractor is not None:
            from labrig.extractors.choice import chosen_extractor

            chosen_extractor(self.extractor)

    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        """See `BatchTask.work`."""
        from labrig.analysis import analyze
        from labrig.extractors.choice import BUILT_IN
        from labrig.report.tables.measurements import measurements_as_dict

        del folder
        found = analyze(item.source.path, extractor=self.extractor or BUILT_IN)
        readings = [reading for condition in found.conditions for reading in condition.readings]
        curves = [condition for condition in found.conditions if condition.curve is not None]
        return BatchAnswer(
            columns={
                "conditions": len(found.conditions),
                "readings": len(readings),
                "invalid": sum(not reading.valid for reading in readings),
                "curves": len(curves),
                "warnings": list(found.warnings),
            },
            whole=measurements_as_dict(found),
        )


TASK = AnalyzeEach

"""Write the report of each session."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from labrig.batch.contract import BatchAnswer, BatchItem, BatchTask, InputKind, option


@dataclass(frozen=True, kw_only=True)
class ReportEach(BatchTask):
    """Write a page with tables and figures about each session.

    each/NAME/index.html is the page. A row lists the parts that had to be left out.
    """

    takes = frozenset({InputKind.SESSION})

    formats: tuple[str, ...] = option(
        "of figures: png, svg, pdf; repeatable; default png and svg", default=(), flag="--format"
    )

    def check(self) -> None:
        """See `BatchTask.check`."""
        from labrig.report.parts.style import known_formats

        known_formats(self.formats)

    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        """See `BatchTask.work`."""
        from labrig.report.page.write import write_report
        from labrig.report.parts.style import known_formats

        told: list[str] = []
        folder.parent.mkdir(parents=True, exist_ok=True)
        page = write_report(
            item.source.path, folder, formats=known_formats(self.formats), tell=told.append
        )
        text = page.read_bytes()
        told = [one.replace(str(item.source.path), item.source.name) for one in told]
        return BatchAnswer(
            columns={"bytes": len(text), "told": told},
            whole={"page_sha256": hashlib.sha256(text).hexdigest()},
        )


TASK = ReportEach

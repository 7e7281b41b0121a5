"""Verify each session."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from labrig.batch.contract import BatchAnswer, BatchItem, BatchTask, InputKind


@dataclass(frozen=True, kw_only=True)
class VerifyEach(BatchTask):
    """Check structure, checksums and completeness of each session.

    A row states whether the file is in order, and which checks failed.
    """

    takes = frozenset({InputKind.SESSION})
    counted = ("in_order", "failed")

    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        """See `BatchTask.work`."""
        from labrig.session import verify

        del folder
        path = item.source.path
        checks = [check.as_dict() for check in verify(path)]
        for check in checks:  # a fault names the file: by its path, which differs between computers
            check["found"] = str(check["found"]).replace(str(path), item.source.name)
        failed = [str(check["name"]) for check in checks if not check["ok"]]
        why = next((str(check["found"]) for check in checks if not check["ok"]), None)
        return BatchAnswer(
            columns={
                "in_order": not failed,
                "failed": failed,
                "checks": len(checks),
                "first_fault": why,
            },
            whole=checks,
        )


TASK = VerifyEach

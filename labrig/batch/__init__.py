"""Many sessions, tables or models: the same task for each, in several processes or on a cluster.

What other people's code may use: the contract of a task, and the loop with its executors.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from labrig.lazy_imports import lazily

if TYPE_CHECKING:
    from labrig.batch.contract import BatchAnswer as BatchAnswer
    from labrig.batch.contract import BatchInput as BatchInput
    from labrig.batch.contract import BatchItem as BatchItem
    from labrig.batch.contract import BatchTask as BatchTask
    from labrig.batch.contract import InputKind as InputKind
    from labrig.batch.contract import Measure as Measure
    from labrig.batch.contract import option as option
    from labrig.batch.loop import Ended as Ended
    from labrig.batch.loop import worked as worked
    from labrig.batch.pool import LocalPool as LocalPool
    from labrig.batch.pool import WorkerLostError as WorkerLostError

_HOMES = {
    "labrig.batch.contract": (
        "BatchAnswer",
        "BatchInput",
        "BatchItem",
        "BatchTask",
        "InputKind",
        "Measure",
        "option",
    ),
    "labrig.batch.loop": ("Ended", "worked"),
    "labrig.batch.pool": ("LocalPool", "WorkerLostError"),
}
__getattr__, __dir__, __all__ = lazily(__name__, _HOMES)

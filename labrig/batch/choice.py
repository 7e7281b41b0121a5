"""The batch tasks there are: ours, and those of other distributions."""

from __future__ import annotations

from typing import Final

from drivers.plugins import PluginFolder
from labrig.batch.conformance import faults
from labrig.batch.contract import BatchTask

BATCH_TASKS: Final[PluginFolder[type[BatchTask]]] = PluginFolder(
    what="batch task",
    package="labrig.batch.tasks",
    constant="TASK",
    group="labrig.batch_tasks",
    faults=faults,
)


def version_of(name: str, task: BatchTask) -> str:
    """Return the version of a task, with the distribution that it is from."""
    origin = BATCH_TASKS.origins().get(name, "")
    return f"{task.version()} {origin}".strip()

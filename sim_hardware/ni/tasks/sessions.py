"""Tasks by their session names.

The real server knows no owners: whoever names a task gets it, and it lives until it is cleared. A
local driver is stricter: a task belongs to the process that made it (`strict`).
"""

from __future__ import annotations

import itertools
from enum import IntEnum

from sim_hardware.ni.errors import Code, SessionError, StatusError
from sim_hardware.ni.tasks.task import Task


class Behaviour(IntEnum):
    """nidaqmx.SessionInitializationBehavior."""

    AUTO = 0
    NEW = 1
    ATTACH = 2


class Sessions:
    """All tasks of the server."""

    def __init__(self, *, strict: bool) -> None:
        self._strict = strict
        self._tasks: dict[tuple[str, str], Task] = {}
        self._numbers = itertools.count()

    def create(self, name: str, behaviour: int, client: str) -> tuple[Task, bool]:
        """Return the task of that name, and whether it is a new one."""
        owner = client if self._strict else ""
        found = self._tasks.get((owner, name)) if name else None
        if behaviour == Behaviour.ATTACH and found is None:
            raise SessionError(
                f"Cannot attach to '{name}' because a session has not been initialized.",
                exists=False,
            )
        if found is None:
            return self._new(name, owner), True
        if behaviour == Behaviour.NEW:
            raise SessionError(
                f"Cannot initialize '{name}' when an initialized session already exists.",
                exists=True,
            )
        if self._strict and behaviour == Behaviour.AUTO:
            raise StatusError(Code.DUPLICATE_TASK, task=name)
        return found, False

    def find(self, name: str, client: str) -> Task:
        """Return the task of that name; -200088 when there is none (for this client)."""
        task = self._tasks.get((client if self._strict else "", name))
        if task is None:
            raise StatusError(Code.INVALID_TASK, task=name)
        return task

    def forget(self, task: Task) -> None:
        """Remove a task."""
        self._tasks.pop((task.owner, task.name), None)

    def all(self) -> list[Task]:
        """Every task."""
        return list(self._tasks.values())

    def of_client(self, client: str) -> list[Task]:
        """Return the tasks that belong to a client; none where tasks have no owner."""
        return [task for task in self._tasks.values() if task.owner and task.owner == client]

    def _new(self, name: str, owner: str) -> Task:
        number = next(self._numbers)
        task = Task(name=name or f"_unnamedTask<{number:X}>", owner=owner, number=number)
        self._tasks[owner, task.name] = task
        return task

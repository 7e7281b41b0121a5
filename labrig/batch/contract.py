"""What a batch task is: the contract of every file in `labrig/batch/tasks`.

A task says what is done with one input (a session, tables, a model file), in a worker process. It
is one frozen, keyword-only dataclass, handed on as the module's `TASK`; its fields, made by
`option`, are options of `labrig batch NAME` with the same names. Another distribution adds one by
an entry point of the group `labrig.batch_tasks`; the entry point's name is the command's.

The modules are imported by `labrig batch --help`: import what is slow inside the methods. A task
and its items travel to other processes and computers, so they hold plain values alone.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any, ClassVar


class InputKind(StrEnum):
    """What a task is done with."""

    SESSION = "session"  # a recorded session, NAME.h5
    TABLES = "tables"  # a sheet.toml with forces.csv, curves.csv, signals.csv beside it
    MODEL = "model"  # a model file, as labrig fit writes it


@dataclass(frozen=True)
class BatchInput:
    """A file that was asked for. `name`: its path as seen from where the results' folder lies."""

    kind: InputKind
    path: Path
    name: str

    @property
    def files(self) -> tuple[Path, ...]:
        """All files that are read."""
        if self.kind is not InputKind.TABLES:
            return (self.path,)
        return (self.path, *(path for path in self.tables.values() if path is not None))

    @property
    def tables(self) -> dict[str, Path | None]:
        """The CSV tables beside a sheet.toml, by their names; None for one that is not there."""
        beside = {name: self.path.with_name(f"{name}.csv") for name in TABLES}
        return {name: path if path.is_file() else None for name, path in beside.items()}


TABLES = ("forces", "curves", "signals")


@dataclass(frozen=True, kw_only=True)
class BatchItem:
    """One piece of work: an input, and what is special about this piece of it."""

    source: BatchInput
    part: Mapping[str, Any] = field(default_factory=dict)  # such as a seed, or a length
    label: str = ""  # tells the parts of one input apart

    @property
    def name(self) -> str:
        """What the row is called: the same in every run of the batch."""
        return f"{self.source.name} {self.label}".rstrip()


@dataclass(frozen=True, kw_only=True)
class BatchAnswer:
    """What a task found. Numbers are finite or None."""

    columns: Mapping[str, Any]  # of the table: numbers, texts, booleans, lists of texts
    # everything, as plain JSON: its checksum is kept, and itself where there is a folder for it.
    # The same input must give the same one, so no times and no paths.
    whole: Any
    files: Mapping[str, str] = field(default_factory=dict)  # further texts to write, by ending


@dataclass(frozen=True, kw_only=True)
class Measure:
    """Columns `NAME[group]` of one quantity, whose distributions and trends a summary shows."""

    column: str
    title: str
    unit: str
    scale: float = 1.0  # from the column's unit to `unit`


@dataclass(frozen=True, kw_only=True)
class BatchTask(ABC):
    """A task with the values of its options. The class's docstring is the command's help."""

    takes: ClassVar[frozenset[InputKind]]
    measures: ClassVar[Sequence[Measure]] = ()
    counted: ClassVar[Sequence[str]] = ()  # columns whose texts, or yes and no, are counted

    def check(self) -> None:  # noqa: B027 - most tasks need none
        """Raise LabrigError where options do not fit; called once, before anything is done."""

    def items(self, source: BatchInput) -> Iterator[BatchItem]:
        """Yield the pieces of work that an input makes: by default one."""
        yield BatchItem(source=source)

    def warm_up(self) -> None:  # noqa: B027 - most tasks compile nothing
        """Have compiled what `work` needs, so that workers find it; called once, before them."""

    @abstractmethod
    def work(self, item: BatchItem, folder: Path) -> BatchAnswer:
        """Do one piece of work, in one thread of a worker process; it may take minutes.

        `folder` is the piece's own, for what is no text; it is not there yet. The process may be
        killed at any moment and the piece done again, so files must appear whole. Raises
        LabrigError or ModelError of one sentence for a fault of the input, which is not tried
        again.
        """

    def version(self) -> str:
        """Return what decides what is found, beside options and files; a change does all again."""
        from importlib.metadata import version

        return version("labrig")


def option(description: str, *, default: Any, **more: Any) -> Any:
    """Return a field that is an option of the command.

    Its type is a bool, int, float, str or Path, one of those `| None`, or a tuple of them, which
    makes the option repeatable. `more`: `min`, `max`, `metavar`, and `flag` where the option is not
    named after the field.
    """
    return field(default=default, metadata={"description": description, **more})

"""The commands of `labrig batch`, each made from its task when it is asked for."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import Field, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer
from typer.core import TyperGroup

from labrig.cli.batch.examples import EXAMPLES
from labrig.cli.command import example_help
from labrig.cli.options import Json

if TYPE_CHECKING:
    from labrig.batch.contract import BatchTask

_PATTERNS = Annotated[
    list[str],
    typer.Argument(
        metavar="FILE|FOLDER|PATTERN",
        help="files, folders with all below them, or patterns such as 'DATA/**/*.h5', which labrig "
        "expands",
    ),
]
_OUTPUT = Annotated[
    Path, typer.Option("--output", "-o", help="the folder of the results; each task has its own")
]
_WORKERS = Annotated[
    int | None,
    typer.Option(min=1, max=1024, help="processes, one core each; by default one for each core"),
]
_SCHEDULER = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="of a Dask scheduler, such as tcp://node1:8786, instead of processes (pip install "
        "labrig[cluster])",
    ),
]
_RETRY = Annotated[
    bool, typer.Option("--retry-errors", help="do again what ended with an error before")
]
_LIMIT = Annotated[
    int | None, typer.Option(min=0, help="do at most so many now; the same command goes on")
]
_DRY_RUN = Annotated[
    bool, typer.Option("--dry-run", help="print what would be done, and do nothing")
]

_COMMON: tuple[tuple[str, Any, Any], ...] = (
    ("output", _OUTPUT, Path("batch")),
    ("workers", _WORKERS, None),
    ("scheduler", _SCHEDULER, None),
    ("retry_errors", _RETRY, False),
    ("limit", _LIMIT, None),
    ("dry_run", _DRY_RUN, False),
    ("as_json", Json, False),
)


class BatchGroup(TyperGroup):
    """A group whose commands are the batch tasks there are; `labrig --help` does not need them."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the tasks' names."""
        del ctx
        from labrig.batch.choice import BATCH_TASKS

        return sorted(BATCH_TASKS.parts())

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return the command of a task; None where there is none of that name."""
        del ctx
        from labrig.batch.choice import BATCH_TASKS

        part = BATCH_TASKS.parts().get(cmd_name)
        if part is None:
            return None
        command = command_of(cmd_name, part.part)
        command.epilog = example_help(EXAMPLES, f"labrig batch {cmd_name}")
        return command


def command_of(name: str, task: type[BatchTask]) -> Any:
    """Return the command with the task's options and those that all tasks have."""
    app = typer.Typer(add_completion=False, rich_markup_mode=None)
    app.command(name=name)(_function(name, task))
    return typer.main.get_command(app)


def _function(name: str, task: type[BatchTask]) -> Callable[..., None]:
    own = [one.name for one in fields(task)]

    def perform(**given: Any) -> None:
        from labrig.cli.batch.perform import BatchRequest, perform_batch

        values = {key: given.pop(key) for key in own}
        made = task(**{k: tuple(v) if isinstance(v, list) else v for k, v in values.items()})
        perform_batch(name, made, BatchRequest(**given))

    keyword = inspect.Parameter.KEYWORD_ONLY
    parameters = [inspect.Parameter("patterns", keyword, annotation=_PATTERNS)]
    hints = get_type_hints(task)
    parameters += [
        inspect.Parameter(
            one.name, keyword, default=_default(one), annotation=_annotation(one, hints[one.name])
        )
        for one in fields(task)
    ]
    parameters += [
        inspect.Parameter(key, keyword, default=default, annotation=annotation)
        for key, annotation, default in _COMMON
    ]
    perform.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    perform.__annotations__ = {one.name: one.annotation for one in parameters}
    perform.__doc__ = inspect.getdoc(task)
    return perform


def _default(one: Field[Any]) -> Any:
    return list(one.default) if isinstance(one.default, tuple) else one.default


def _annotation(one: Field[Any], hint: Any) -> Any:
    from labrig.batch.conformance import value_type

    kind, repeatable = value_type(hint)
    about = one.metadata
    flag = about.get("flag") or "--" + re.sub("_", "-", one.name)
    more = {key: about[key] for key in ("min", "max", "metavar") if key in about}
    shown = one.default is not None and one.default is not False and one.default != ()
    made = typer.Option(flag, help=about["description"], show_default=shown and not repeatable,
                        **more)  # fmt: skip
    whole = list[kind] if repeatable else hint  # type: ignore[valid-type]
    return Annotated[whole, made]

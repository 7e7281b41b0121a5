"""The same task for many sessions, tables or models."""

from __future__ import annotations

import typer

from labrig.cli.batch.examples import EXAMPLES
from labrig.cli.batch.group import BatchGroup
from labrig.cli.command import Command

app = typer.Typer(
    cls=BatchGroup,
    no_args_is_help=True,
    help="""Do the same for many sessions, tables or models.

    It runs in several processes, or on a cluster.

    Each result is a line of rows.jsonl, written as it ends. After an interruption the same command
    continues, and repeats only what has changed. All results are also one table (CSV, and Parquet
    where pyarrow is installed) and a summary with figures.""",
)


@app.callback()
def batch() -> None:
    """Have a task by name, which is asked for when it is needed."""


COMMAND = Command("batch", app, order=185, examples=EXAMPLES)

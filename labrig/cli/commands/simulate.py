"""What a model predicts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command
from labrig.cli.model_errors import errors_of, say_errors, warn_of_misses
from labrig.cli.options import EachConfiguration, Json, ModelFile
from labrig.cli.screen import print_json, print_table
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from model import Prediction


def simulate(
    model: ModelFile,
    configuration: EachConfiguration = None,
    position_mm: Annotated[
        list[float] | None, typer.Option(help="along the arc; repeatable")
    ] = None,
    voltage: Annotated[list[float] | None, typer.Option(help="in V; repeatable")] = None,
    session: Annotated[
        int,
        typer.Option(
            min=0, help="as in this one of the sessions diagnosed together; 0: as in their mean"
        ),
    ] = 0,
    as_json: Json = False,
) -> None:
    """Force and shape that a model predicts, for all combinations of what is given."""
    from labrig.model_file import load_model
    from model import predict

    if not position_mm or not voltage:
        raise BadInputError("give at least one --position-mm and one --voltage.")
    known = load_model(model)
    if session > known.sessions:
        many = f"more than {known.sessions} sessions" if known.sessions else "sessions"
        raise BadInputError(
            f"--session {session}: {model.name} has nothing that differs between {many}."
        )
    known = known.in_session(session)
    found = [
        predict(known, name, 1e-3 * position, volts)
        for name in configuration or known.sheets
        for position in position_mm
        for volts in voltage
    ]
    errors = errors_of(known, dict.fromkeys(one.configuration for one in found))
    warn_of_misses(errors)
    if as_json:
        print_json([one.to_json() for one in found])
        return
    columns = ["sheet", "p mm", "V", "F mN", "N mN", "contact at mm", "angle deg", "remark"]
    print_table(f"{model}", columns, [_prediction_row(one) for one in found])
    say_errors(errors)


def _prediction_row(found: Prediction) -> list[str]:
    import math

    from labrig.report.parts.table import fixed

    return [
        found.configuration,
        f"{1e3 * found.position_m:g}",
        f"{found.voltage_V:+g}",
        fixed(1e3 * found.F_N, 3),
        fixed(1e3 * found.N_N, 3),
        fixed(1e3 * found.s_hat_m, 2),
        fixed(math.degrees(found.phi_hat_rad), 2),
        found.why or "-",
    ]


COMMAND = Command("simulate", simulate, order=150)

"""A controller of the force, designed from a model of the sheet in time."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import ModelFile
from labrig.cli.screen import print_table, say
from labrig.errors import BadInputError


class Controlled(StrEnum):
    """What is controlled."""

    FORCE = "force"


class ControlMethod(StrEnum):
    """How the controller is found."""

    PI = "pi"
    LQG = "lqg"


def control(
    model: ModelFile,
    position_mm: Annotated[float, typer.Option(help="of the load cell along the arc")],
    output: Annotated[  # noqa: ARG001 - the only one there is
        Controlled, typer.Option(help="what is controlled")
    ] = Controlled.FORCE,
    configuration: Annotated[
        str | None, typer.Option(help="needed where the model has several")
    ] = None,
    rate_hz: Annotated[float, typer.Option(help="writes of the voltage in a second")] = 200.0,
    delay_ms: Annotated[
        float, typer.Option(help="from a force to its voltage, the samples' mean age included")
    ] = 3.0,
    method: Annotated[
        ControlMethod, typer.Option(help="pi, or lqg with an integrator")
    ] = ControlMethod.LQG,
    limit_V: Annotated[
        float | None, typer.Option("--limit-V", help="of the voltage; by default 2 V")
    ] = None,
    rig: Annotated[
        Path | None, typer.Option(help="rig.toml: the controller is for this rig only")
    ] = None,
    path: Annotated[
        Path, typer.Option("--file", "-o", help="where the controller is written")
    ] = Path("controller.toml"),
) -> None:
    """Design a controller of the force, and say what it does.

    It is linear, about rest at 0 V, with the mean of the moments per volt for positive and negative
    voltages.

    `labrig run --controller` uses it. PI has the highest integral gain at which the sensitivity's
    peak Ms stays below 1.6; LQG keeps the same bound.
    """
    from labrig.control.controller_file import (
        FASTEST_HZ,
        LONGEST_DELAY_MS,
        SLOWEST_HZ,
        save_controller,
    )
    from labrig.control.sheet_loop import (
        LoopGoal,
        controller_config,
        design_loop,
        linear_sheet,
    )

    _within("--rate-hz", rate_hz, SLOWEST_HZ, FASTEST_HZ)
    _within("--delay-ms", delay_ms, 0.0, LONGEST_DELAY_MS)
    loop = LoopGoal(
        method=method.value,
        rate_hz=rate_hz,
        delay_s=1e-3 * delay_ms,
        limit_V=_limit_V(limit_V, rig),
    )
    sheet = linear_sheet(model, configuration, 1e-3 * position_mm)
    made = design_loop(sheet, loop, model)
    save_controller(controller_config(sheet, loop, made, model, rig), path)
    step = made.step
    print_table(
        f"{path}: {method.value}, {sheet.sheet.configuration} at {position_mm:g} mm",
        ["figure", "value"],
        [
            ["gain at rest", f"{1e3 * sheet.system.static_gain[0, 0]:.3f} mN/V"],
            ["integral gain", f"{1e-3 * made.controller.integral_gain:.1f} V/(mN s)"],
            ["sensitivity peak Ms", f"{made.sensitivity_peak:.2f}"],
            [f"step of {1e3 * step.step_N:g} mN: 90 % after", f"{1e3 * step.rise_s:.0f} ms"],
            ["within 2 % after", f"{1e3 * step.settled_s:.0f} ms"],
            ["overshoot", f"{100 * step.overshoot:.1f} %"],
        ],
    )
    say(f"wrote {path}")


def _limit_V(limit_V: float | None, rig: Path | None) -> float:
    """Return the largest voltage of the controller: what was asked for, and the rig allows."""
    from labrig.control.controller_file import HIGHEST_V
    from labrig.control.sheet_loop import DEFAULT_LIMIT_V, rig_limit_V

    if limit_V is not None and not 0.0 < limit_V <= HIGHEST_V:
        raise BadInputError(
            f"--limit-V {limit_V:g}: a positive voltage of at most {HIGHEST_V:g} V is needed."
        )
    allowed_V = HIGHEST_V if rig is None else rig_limit_V(rig)
    if limit_V is not None and limit_V > allowed_V:
        raise BadInputError(
            f"--limit-V {limit_V:g}: {rig} allows {allowed_V:g} V at the sheet at most ([limits]"
            " sheet_voltage_V); give no more."
        )
    return min(DEFAULT_LIMIT_V, allowed_V) if limit_V is None else limit_V


def _within(option: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise BadInputError(f"{option} {value:g}: a number from {low:g} to {high:g} is needed.")


COMMAND = Command(
    "control",
    control,
    order=156,
    examples=(
        CommandExample(line="labrig control dynamic.toml --position-mm 5 -o controller.toml"),
    ),
)

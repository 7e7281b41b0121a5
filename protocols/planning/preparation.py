"""What has to be done by hand, or by the stage, before a run: always at 0 V."""

from __future__ import annotations

from dataclasses import dataclass, replace

from drivers.interfaces import Prompt
from protocols.planning.schedule import PlannedRun, Purpose


@dataclass(frozen=True, kw_only=True)
class Situation:
    """How sheet and load cell are set, as far as the session knows."""

    configuration: str | None = None  # mounted in the clamp
    mounting: int = 0
    touching: bool = False  # the sheet is between the rolls of the load cell
    loaded: bool = False  # a dead weight hangs on the load cell
    turned_over: bool = False  # the whole rig, about the sheet's long axis


@dataclass(frozen=True)
class Move:
    """Bring the load cell to a position along the arc."""

    position_m: float


Action = Prompt | Move


def preparation(before: Situation, run: PlannedRun) -> tuple[list[Action], Situation]:
    """Return what to do before a run, in order, and the situation that it leads to."""
    if run.tilt_rad and not before.turned_over:
        actions, now = preparation(replace(before, turned_over=True), run)
        return [_turn_over(run), *actions], now
    if run.purpose is Purpose.DEAD_WEIGHT:
        load_N = run.load_N or 0.0
        return [_weigh(run, load_N)], replace(before, touching=False, loaded=load_N > 0)
    actions = [_weigh(run, 0.0)] if before.loaded else []
    now = replace(before, loaded=False)
    mounted = replace(now, configuration=run.configuration, mounting=run.mounting, touching=False)
    if before.configuration != run.configuration:
        actions.append(_mount(run))
        now = mounted
    elif run.mounting > 0 and run.repeats is None:  # every such run is a position set anew
        actions.append(_remount(run))
        now = mounted
    if run.purpose in (Purpose.MEASUREMENT, Purpose.CONTROL) and run.position_m is not None:
        actions += _approach(run, run.position_m, touching=now.touching)
        now = replace(now, touching=True)
    else:
        actions += [Move(run.position_m)] if run.position_m is not None else []
        actions.append(_free(run))
        now = replace(now, touching=False)
    if run.moisten:
        actions.append(_moisten(run))
    return actions, now


def _approach(run: PlannedRun, position_m: float, *, touching: bool) -> list[Action]:
    """Put the sheet between the rolls before the last move, which gives the side."""
    touch: list[Action] = [] if touching else [_touch(run)]
    if run.via_m is None:
        return [Move(position_m), *touch]
    return [Move(run.via_m), *touch, Move(position_m)]


def _turn_over(run: PlannedRun) -> Prompt:
    text = (
        "Turn the whole rig over about the sheet's long axis, unless it is turned over already; it "
        "stays so for this session. Turn it back afterwards."
    )
    return Prompt(kind="turn_over", text=text, configuration=run.configuration)


def _weigh(run: PlannedRun, load_N: float) -> Prompt:
    text = (
        f"Hang {load_N * 1e3:g} mN on the load cell, along its sensitive direction, and wait until "
        "it hangs still."
        if load_N
        else "Take every weight and the sheet off the load cell."
    )
    return Prompt(kind="dead_weight", text=text, configuration=run.configuration, load_N=load_N)


def _mount(run: PlannedRun) -> Prompt:
    text = f"Mount the sheet in the configuration {run.configuration!r} in the clamp."
    return Prompt(kind="mount", text=text, configuration=run.configuration)


def _remount(run: PlannedRun) -> Prompt:
    text = (
        f"Take the {run.configuration!r} sheet out of the clamp and mount it anew, as if for the "
        "first time."
    )
    return Prompt(
        kind="remount", text=text, configuration=run.configuration, position_m=run.position_m
    )


def _touch(run: PlannedRun) -> Prompt:
    text = "Put the sheet between the rolls of the load cell."
    return Prompt(
        kind="touch",
        text=text,
        configuration=run.configuration,
        position_m=run.position_m if run.via_m is None else run.via_m,
    )


def _free(run: PlannedRun) -> Prompt:
    text = (
        "Take the load cell away from the sheet, so that nothing touches the sheet."
        if run.position_m is None
        else f"Lift the sheet out of the rolls and leave the load cell at "
        f"{run.position_m * 1e3:g} mm."
    )
    return Prompt(
        kind="free", text=text, configuration=run.configuration, position_m=run.position_m
    )


def _moisten(run: PlannedRun) -> Prompt:
    return Prompt(
        kind="moisten",
        text="Moisten the sheet.",
        configuration=run.configuration,
        position_m=run.position_m,
    )

"""A plan as pages see it."""

from __future__ import annotations

from drivers.load_cell import LoadCell
from labrig.experiment.next_measurement.dynamic_needs import not_determined
from labrig.experiment.plan import Plan
from labrig.experiment.preflight import doubts
from labrig.experiment.rig.channels import planned_channels
from labrig.panel.live.event_stream import Message
from labrig.panel.live.messages import plan_message
from labrig.vision import Optics


def message_of_plan(
    plan: Plan, clock: str, session: str | None, done: frozenset[int] = frozenset()
) -> Message:
    """Return the plan as pages see it."""
    limits = plan.rig.limits
    return plan_message(
        plan.schedule,
        clock=clock,
        session=session,
        simulated=plan.rig.is_simulated,
        limits={
            "sheet_voltage_V": limits.sheet_voltage_V,
            "time_under_voltage_s": limits.time_under_voltage_s,
            "capacity_mN": 1e3 * plan.calibration.capacity_N,
        },
        picture=optics_message(plan.optics),
        channels=planned_channels(plan.rig, LoadCell(plan.calibration)),
        done=done,
        warnings=[
            *(check.in_words for check in doubts(plan)),
            *not_determined(plan.protocol, plan.schedule, plan.rig),
        ],
    )


def optics_message(optics: Optics | None) -> Message | None:
    """Where the sheet's plane is in the picture."""
    if optics is None:
        return None
    width, height = optics.image_size or (None, None)
    return {
        "width": width,
        "height": height,
        "clamp_px": list(optics.clamp_px),
        "px_per_mm": optics.px_per_mm,
    }

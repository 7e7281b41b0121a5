"""Checks without a device: who writes 0 V when program and guard are gone, and punctuality."""

from __future__ import annotations

from collections.abc import Iterator

from drivers.interfaces import Clock, RealClock
from drivers.real_time import EDGES, punctual
from labrig.check import Check
from labrig.config import RigConfig
from labrig.experiment.plan import Plan

LOOK_S = 0.5  # how long this computer is watched
_TICK_S = 0.005


def precautions(plan: Plan, clock: Clock | None = None) -> Iterator[Check]:
    """Yield the checks of a real rig; each is at most a warning."""
    if not plan.rig.is_simulated:
        yield beyond_the_guard(plan.rig)
        yield on_time(clock or RealClock(), plan.protocol.rules.late_edge_s)


def beyond_the_guard(config: RigConfig) -> Check:
    """Say what ends a voltage where the program and its guard, on one computer, are both gone."""
    found = []
    if config.watch is not None:
        found.append(f"labrig watch at {config.watch.address}")
    if config.own_watchdog:
        found.append(config.own_watchdog)
    elif config.interlock_line is not None:
        found.append(f"the interlock on {config.interlock_line}")
    return Check(
        name="beyond the guard",
        ok=True,
        found=" and ".join(found) or "nobody writes 0 V if this computer or the network fails",
        wanted="[watch], [interlock] or boards with a watchdog (docs/explanation/safety.md)",
        warning=not found,
    )


def on_time(clock: Clock, limit_s: float) -> Check:
    """Measure how late this computer wakes who has to write an edge.

    With the priority that a run has. A computer that is late now will be late in the run.
    """
    late_s = 0.0
    with punctual(EDGES):
        due_s = clock.now()
        end_s = due_s + LOOK_S
        while due_s < end_s:
            due_s = max(due_s, clock.now()) + _TICK_S
            clock.sleep_until(due_s)
            late_s = max(late_s, clock.now() - due_s)
    return Check(
        name="computer on time",
        ok=True,
        found=f"up to {1e3 * late_s:.1f} ms late in {LOOK_S:g} s"
        + ("; it is busy, and readings would be lost" if late_s > limit_s else ""),
        wanted=f"at most {1e3 * limit_s:g} ms",
        warning=late_s > limit_s,
    )

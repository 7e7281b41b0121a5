"""What follows a step of 2 V: charge along the sheet, force and current, the free sheet's swing."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drawings._sheet import FORCE, HELP, INK, RADIUS_MM, SHEET
from model.dynamics import (
    ContactSetup,
    DynamicBeam,
    ElectrodeLine,
    HeldVoltage,
    LineModes,
    Viscoelasticity,
    fluid_load,
    simulate,
)
from model.mechanics.field import Field

LENGTH_M, B_NM2, EDGE_S, VOLTS = 0.05, 1.27e-6, 0.02, 2.0
LINE = ElectrodeLine(
    electrode_ohm_per_m=4000.0, capacitance_F_per_m=0.3, bulk_ohm_m=0.5, leak_S_per_m=0.1
)
DRIVE = HeldVoltage(np.array([EDGE_S]), np.array([VOLTS]))


def figure() -> Figure:
    """Return the drawing."""
    drawing = Figure(figsize=(9.6, 3.1), layout="constrained")
    axes = [drawing.add_subplot(1, 3, k + 1) for k in range(3)]
    _charge(axes[0])
    _signals(axes[1])
    _swing(axes[2])
    return drawing


def _sheet() -> DynamicBeam:
    return DynamicBeam(
        length_m=LENGTH_M, mass_per_length_kg_per_m=5.775e-3,
        material=Viscoelasticity(
            B_Nm2=B_NM2, shares=(0.15, 0.10), times_s=(0.02, 0.3), viscous_time_s=2e-4
        ),
        rest=Field.smooth(lambda s: 24.0 * np.exp(-s / 0.04), LENGTH_M), electrodes=LINE,
        moment_per_volt_Nm=(30.0 * B_NM2, 30.0 * B_NM2),
        fluid=fluid_load(0.011, 1.2, 1.82e-5, 3.3, drag_coefficient=2.0),
    )  # fmt: skip


def _charge(axes: Axes) -> None:
    modes = LineModes(LINE, LENGTH_M, 12)
    s_m = np.linspace(0.0, LENGTH_M, 101)
    for shade, after_ms in zip((0.35, 0.55, 0.75, 1.0), (10, 50, 200, 600), strict=True):
        state = modes.respond(np.zeros(12), np.array([1e-3 * after_ms]), np.array([VOLTS]))[-1]
        U = modes.at(s_m) @ state
        axes.plot(1e3 * s_m, U, color=SHEET, alpha=shade)
        axes.text(1e3 * s_m[12], U[12] + 0.07, f"{after_ms} ms", color=INK, fontsize=8)
    axes.set(xlabel="s, mm from the clamp", ylabel="double layer U, V", title="charge spreads")


def _signals(axes: Axes) -> None:
    times = np.arange(0.0, 0.6, 1e-3)
    rolls = ContactSetup(radius_m=1e-3 * RADIUS_MM, position_m=0.005)
    motion = simulate(_sheet(), rolls, DRIVE, times, s_m=np.zeros(0))
    t = 1e3 * (times - EDGE_S)
    axes.plot(t, 1e3 * motion.force_N, color=FORCE, label="force, mN")
    axes.plot(t, 20.0 * motion.current_A, color=HELP, label="current, in 50 mA")
    axes.set(xlabel="ms after the step", title="held by the rolls")
    axes.legend(frameon=False, fontsize=8)


def _swing(axes: Axes) -> None:
    times = EDGE_S + 0.04 * np.arange(13)
    motion = simulate(_sheet(), None, DRIVE, times, s_m=np.linspace(0.0, LENGTH_M, 41))
    for k, (x, y) in enumerate(zip(motion.x_m, motion.y_m, strict=True)):
        axes.plot(1e3 * x, 1e3 * y, color=SHEET, lw=1, alpha=0.25 + 0.75 * k / (len(times) - 1))
    axes.set_aspect("equal")
    axes.set(xlabel="x, mm", ylabel="y, mm", title="free: a shape every 40 ms")

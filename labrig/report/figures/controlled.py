"""A controlled run: the force that was asked for and measured, the linear model's, the voltage."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from labrig.control.controller_file import ControllerConfig
from labrig.report.parts.style import (
    INK,
    NEGATIVE,
    POSITIVE,
    figure,
    legend_below,
    letter,
    panels_width_in,
)
from labrig.session import RunRecord
from model.measurements import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AT_THE_LIMIT = 0.999


@dataclass(frozen=True, kw_only=True)
class ControlledRun:
    """What a controller did, period by period, beside the linear model of its file."""

    time_s: FloatArray  # (n,)
    reference_N: FloatArray
    force_N: FloatArray  # above that at 0 V
    voltage_V: FloatArray
    linear_N: FloatArray
    linear_V: FloatArray
    limit_V: float

    @classmethod
    def of(cls, run: RunRecord, controller: ControllerConfig, limit_V: float) -> ControlledRun:
        """Return a run that a controller has made, at least one period of it."""
        rows, limit = run.control, min(controller.limits.voltage_V, limit_V)
        reference_N = np.asarray(rows["reference_N"])
        linear_N, linear_V = controller.controller.follow(
            controller.plant_model, reference_N, limit
        )
        return cls(
            time_s=np.asarray(rows["planned_s"]),
            reference_N=reference_N,
            force_N=np.asarray(rows["force_N"]),
            voltage_V=np.asarray(rows["sheet_V"]),
            linear_N=linear_N,
            linear_V=linear_V,
            limit_V=limit,
        )

    def off_N(self, force_N: FloatArray) -> tuple[float, float]:
        """Return RMS and largest difference of a force from the reference."""
        off = force_N - self.reference_N
        return float(np.sqrt(np.mean(off**2))), float(np.max(np.abs(off)))

    def limited(self, voltage_V: FloatArray) -> float:
        """Return the share of periods with the voltage at its limit."""
        return float(np.mean(np.abs(voltage_V) >= AT_THE_LIMIT * self.limit_V))


def controlled_figure(found: ControlledRun) -> Figure:
    """Draw force and voltage beside each other."""
    with figure(panels_width_in(2), 3.0) as fig:
        force, voltage = fig.subplots(1, 2)
        asked = force.step(
            found.time_s,
            1e3 * found.reference_N,
            where="post",
            color=INK,
            lw=0.8,
            label="reference",
        )
        measured = force.plot(
            found.time_s, 1e3 * found.force_N, color=POSITIVE, lw=0.8, label="measured"
        )
        linear = force.plot(
            found.time_s, 1e3 * found.linear_N, color=NEGATIVE, lw=1.2, label="linear model"
        )
        voltage.plot(found.time_s, found.voltage_V, color=POSITIVE, lw=0.8)
        voltage.plot(found.time_s, found.linear_V, color=NEGATIVE, lw=1.2)
        force.set(xlabel="time (s)", ylabel="force above that at 0 V (mN)")
        voltage.set(xlabel="time (s)", ylabel="voltage at the sheet (V)")
        letter(force, "a", "force")
        letter(voltage, "b", "voltage")
        legend_below(fig, [*asked, *measured, *linear])
        return fig

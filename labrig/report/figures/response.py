"""A linear model's answer to a volt: its step, its Bode plot, its modes, as figure and tables."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from labrig.files import write_text
from labrig.report.parts.style import POSITIVE, figure, letter, panels_width_in
from model.measurements import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from model.dynamics.linear.state_space import LinearSystem

# column, factor from SI, unit
_OUTPUTS = {
    "force": ("force_N", 1e3, "mN"),
    "tip": ("tip_m", 1e3, "mm"),
    "current": ("current_A", 1e3, "mA"),
}
_HZ = np.geomspace(0.01, 200.0, 600)
_STEP_S = np.linspace(0.0, 3.0, 1501)
_MODES, _HIGHEST_HZ = 3, 200.0


@dataclass(frozen=True)
class Mode:
    """A pair of poles that swing."""

    frequency_hz: float
    damping: float  # damping ratio


@dataclass(frozen=True, kw_only=True)
class Response:
    """The answer to one volt, in `unit`."""

    output: str
    unit: str
    gain_at_rest: float
    bandwidth_hz: float | None  # None: it does not fall by 3 dB
    modes: tuple[Mode, ...]
    step_s: FloatArray
    step: FloatArray
    frequencies_hz: FloatArray
    transfer: np.ndarray  # complex, of these frequencies

    @classmethod
    def of(cls, system: LinearSystem, output: str) -> Response:
        """Return the answer of one output of a sheet's linear model."""
        column, factor, unit = _OUTPUTS[output]
        one = system.output(column)
        transfer = factor * one.response(_HZ)[:, 0, 0]
        gain = float(factor * one.static_gain[0, 0])
        fallen = np.flatnonzero(np.abs(transfer) < abs(gain) * np.sqrt(0.5))
        return cls(
            output=output,
            unit=unit,
            gain_at_rest=gain,
            bandwidth_hz=float(_HZ[fallen[0]]) if len(fallen) else None,
            modes=_modes(one),
            step_s=_STEP_S,
            step=factor * one.step(_STEP_S)[:, 0],
            frequencies_hz=_HZ,
            transfer=transfer,
        )

    def write_tables(self, folder: Path) -> tuple[Path, Path]:
        """Write OUTPUT_step.csv and OUTPUT_bode.csv, and return their paths."""
        paths = folder / f"{self.output}_step.csv", folder / f"{self.output}_bode.csv"
        name = f"{self.output}_{self.unit}_per_V"
        _write(paths[0], ("time_s", name), (self.step_s, self.step))
        phase_deg = np.degrees(np.unwrap(np.angle(self.transfer)))
        columns = ("frequency_hz", name, "phase_deg")
        _write(paths[1], columns, (self.frequencies_hz, np.abs(self.transfer), phase_deg))
        return paths


def response_figure(found: Response) -> Figure:
    """Draw step, gain and phase beside each other."""
    with figure(panels_width_in(3), 3.0) as fig:
        step, gain, phase = fig.subplots(1, 3)
        step.plot(found.step_s, found.step, color=POSITIVE)
        step.set(xlabel="time after 1 V (s)", ylabel=f"{found.output} ({found.unit})")
        gain.loglog(found.frequencies_hz, np.abs(found.transfer), color=POSITIVE)
        gain.set(xlabel="frequency (Hz)", ylabel=f"gain ({found.unit}/V)")
        degrees = np.degrees(np.unwrap(np.angle(found.transfer)))
        phase.semilogx(found.frequencies_hz, degrees, color=POSITIVE)
        phase.set(xlabel="frequency (Hz)", ylabel="phase (degrees)")
        for axes, mark, title in zip(
            (step, gain, phase), "abc", ("step", "gain", "phase"), strict=True
        ):
            letter(axes, mark, title)
        return fig


def _modes(system: LinearSystem) -> tuple[Mode, ...]:
    poles = system.poles[system.poles.imag > 0.0]
    poles = poles[np.argsort(np.abs(poles))]
    found = (Mode(abs(p) / (2.0 * np.pi), -p.real / abs(p)) for p in poles)
    return tuple(mode for mode in found if mode.frequency_hz < _HIGHEST_HZ)[:_MODES]


def _write(path: Path, columns: tuple[str, ...], values: tuple[FloatArray, ...]) -> None:
    rows = zip(*values, strict=True)
    lines = [",".join(columns), *(",".join(f"{value:.10g}" for value in row) for row in rows)]
    write_text(path, "\n".join(lines) + "\n")

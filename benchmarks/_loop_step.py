"""Steps of 1 mN in the moving world under control, and the same steps of the linear model."""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from labrig.cli.main import run
from labrig.config import load_sheet
from labrig.config.templates import write_templates
from labrig.control.controller_file import (
    ControlledSheet,
    ControllerConfig,
    ControllerLimits,
    DesignedFor,
    LawMatrices,
    PlantMatrices,
    checksum_of,
    save_controller,
)
from labrig.session import open_session
from model.dynamics.linear.loop_design import LoopDesign, StepFigures, figures_of
from protocols.planning.schedule import ForceStep

STEPS, HALF_S, BEGINS_S = 8, 1.5, 0.5  # up and down again in 3 s; the mean of the steps is judged
STEP_N = 1e-3
SMOOTH = 5  # periods: the board's own noise, 0.03 mN of a period's mean, would hide 2 %
_RIG = ("rig.toml", "protocol.toml", "sheet.toml")
_PROTOCOL = """
moisten = false
[pulse_train]
[[places]]
configuration = "long"
positions_mm = [0]
[extras]
"""
# The shipped moving world with equal moments either way, without what is no dynamics.
_WORLD = """
moving = true
seed = {seed}
[eibm]
saturation_V = 1e6
negative_ratio = 1.0
[water]
first_pulse_deficit = 0.0
stiffening_per_min = 0.0
weakening_per_min = 0.0
[load_cell]
noise_mN = 0.0
drift_mN = 0.0
hum_mN = 0.0
"""


@dataclass(frozen=True)
class Steps:
    """The mean step in the linear model and on the simulated rig."""

    predicted: StepFigures
    found: StepFigures
    code: int


def steps(made: LoopDesign, seed: int) -> Steps:
    """Run the steps under control on the simulated rig of this seed."""
    rate_hz = 1.0 / made.controller.sample_time_s
    times_s, wanted_N = _reference()
    reference = [
        ForceStep(time_s, force_N) for time_s, force_N in zip(times_s, wanted_N, strict=True)
    ]
    end_s = times_s[-1] + HALF_S
    t = np.arange(1, round(end_s * rate_hz)) / rate_hz
    r = np.array(wanted_N)[np.searchsorted(times_s, t + 1e-9, side="right") - 1]
    linear, _ = made.controller.follow(made.plant, r, 2.0)
    code, force_N = _run(made, seed, reference, end_s)
    return Steps(_mean_step(linear, rate_hz), _mean_step(force_N, rate_hz), code)


def _reference() -> tuple[list[float], list[float]]:
    times_s, forces_N = [0.0], [0.0]
    for k in range(STEPS):
        up_s = BEGINS_S + 2 * HALF_S * k
        times_s += [up_s, up_s + HALF_S]
        forces_N += [STEP_N, 0.0]
    return times_s, forces_N


def _mean_step(force_N: np.ndarray, rate_hz: float) -> StepFigures:
    """Return the figures of the mean of the steps up; sample 0 is the first period after t = 0."""
    length = round(HALF_S * rate_hz)
    first = [round((BEGINS_S + 2 * HALF_S * k) * rate_hz) - 1 for k in range(STEPS)]
    mean = np.mean([force_N[k : k + length] for k in first], axis=0)
    smooth = np.convolve(mean, np.ones(SMOOTH) / SMOOTH, mode="same")
    edge = SMOOTH // 2
    smooth[:edge], smooth[-edge:] = mean[:edge], smooth[-edge - 1]
    return figures_of(smooth, 1.0 / rate_hz, STEP_N)


def _run(
    made: LoopDesign, seed: int, reference: list[ForceStep], end_s: float
) -> tuple[int, np.ndarray]:
    with TemporaryDirectory() as name:
        folder = Path(name)
        write_templates(folder, simulated=True)
        (folder / "protocol.toml").write_text(_PROTOCOL)
        (folder / "world.toml").write_text(_WORLD.format(seed=seed))
        rig = folder / "rig.toml"
        rig.write_text(rig.read_text().replace("# world =", "world ="))
        save_controller(_config(made, folder / "sheet.toml"), folder / "controller.toml")
        rows = [f"{step.time_s:g},{1e3 * step.force_N:g}" for step in reference]
        lines = ["time_s,force_mN", *rows, f"{end_s:g},0"]
        (folder / "force.csv").write_text("\n".join(lines) + "\n")
        command = ["run", *(str(folder / file) for file in _RIG), "-o", str(folder / "s.h5")]
        command += ["--yes", "--controller", str(folder / "controller.toml")]
        command += ["--reference", str(folder / "force.csv")]
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            code = run(command)
        with open_session(folder / "s.h5") as session:
            return code, session.runs[0].control["force_N"].copy()


def _config(made: LoopDesign, sheet: Path) -> ControllerConfig:
    law, plant = made.controller.law, made.plant
    rate_hz = 1.0 / made.controller.sample_time_s
    return ControllerConfig(
        labrig_controller=1,
        method="other",
        output="force",
        configuration="long",
        position_mm=0.0,
        rate_hz=rate_hz,
        delay_ms=3.0,
        limits=ControllerLimits(voltage_V=2.0),
        model=DesignedFor(file="model.toml", sha256=checksum_of("")),
        sheet=ControlledSheet.of(load_sheet(sheet)["long"]),
        law=LawMatrices(
            A=law.A.tolist(),
            B=law.B.tolist(),
            C=law.C[0].tolist(),
            D=law.D[0].tolist(),
            anti_windup=made.controller.anti_windup.tolist(),
        ),
        plant=PlantMatrices(
            rate_hz=rate_hz,
            A=plant.A.tolist(),
            B=plant.B[:, 0].tolist(),
            C=plant.C[0].tolist(),
        ),
    )

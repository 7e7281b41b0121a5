"""Steps of 1 mN in the moving world under control, and the same steps of the linear model."""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks._spied_output import highest_V, spied_output, under_voltage_s
from labrig.cli.main import run
from labrig.config.templates import write_templates
from labrig.control.controller_file import save_controller
from labrig.control.sheet_loop import (
    LinearSheet,
    LoopGoal,
    controller_config,
    design_loop,
    linear_sheet,
)
from labrig.model_file import save_model
from labrig.session import open_session
from model.dynamics.linear.feedback import Method
from model.dynamics.linear.loop_design import LoopDesign, StepFigures, figures_of
from tests.labrig.moving_model import model

STEPS, HALF_S, BEGINS_S = 8, 1.5, 0.5  # up and down again in 3 s; the mean of the steps is judged
STEP_N = 1e-3
RATE_HZ, DELAY_S, LIMIT_V = 200.0, 3e-3, 2.0
SMOOTH = 5  # periods: the board's own noise, 0.03 mN of a period's mean, would hide 2 %
_RIG = ("rig.toml", "protocol.toml", "sheet.toml")
_PROTOCOL = """
moisten = false
[pulse_train]
[[places]]
configuration = "long"
positions_mm = [0]
[extras]
mode = "paper"
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
    highest_V: float  # of the board
    under_voltage_s: float


def goal(method: Method) -> LoopGoal:
    """Return the loop of this benchmark."""
    return LoopGoal(method=method, rate_hz=RATE_HZ, delay_s=DELAY_S, limit_V=LIMIT_V)


def steps(method: Method, seed: int) -> Steps:
    """Run the steps under control on the simulated rig of this seed."""
    times_s, wanted_N = _reference()
    with TemporaryDirectory() as name:
        made = _write_files(Path(name), method, seed)
        code, force_N, writes = _run(Path(name))
    t = np.arange(1, round((times_s[-1] + HALF_S) * RATE_HZ)) / RATE_HZ
    r = np.array(wanted_N)[np.searchsorted(times_s, t + 1e-9, side="right") - 1]
    linear, _ = made.controller.follow(made.plant, r, LIMIT_V)
    return Steps(
        predicted=_mean_step(linear),
        found=_mean_step(force_N),
        code=code,
        highest_V=highest_V(writes),
        under_voltage_s=under_voltage_s(writes),
    )


def _reference() -> tuple[list[float], list[float]]:
    times_s, forces_N = [0.0], [0.0]
    for k in range(STEPS):
        up_s = BEGINS_S + 2 * HALF_S * k
        times_s += [up_s, up_s + HALF_S]
        forces_N += [STEP_N, 0.0]
    return times_s, forces_N


def _mean_step(force_N: np.ndarray) -> StepFigures:
    """Return the figures of the mean of the steps up; sample 0 is the first period after t = 0."""
    length = round(HALF_S * RATE_HZ)
    first = [round((BEGINS_S + 2 * HALF_S * k) * RATE_HZ) - 1 for k in range(STEPS)]
    mean = np.mean([force_N[k : k + length] for k in first], axis=0)
    smooth = np.convolve(mean, np.ones(SMOOTH) / SMOOTH, mode="same")
    edge = SMOOTH // 2
    smooth[:edge], smooth[-edge:] = mean[:edge], smooth[-edge - 1]
    return figures_of(smooth, 1.0 / RATE_HZ, STEP_N)


def _write_files(folder: Path, method: Method, seed: int) -> LoopDesign:
    """Write the rig's files, and the controller that the world's own model gives."""
    write_templates(folder, simulated=True)
    (folder / "protocol.toml").write_text(_PROTOCOL)
    (folder / "world.toml").write_text(_WORLD.format(seed=seed))
    rig, path = folder / "rig.toml", folder / "model.toml"
    save_model(model(load_cell=True), path)
    sheet, made = _designed(method)
    config = controller_config(sheet, goal(method), made, path, rig)
    save_controller(config, folder / "controller.toml")
    times_s, wanted_N = _reference()
    rows = [f"{at_s:g},{1e3 * N:g}" for at_s, N in zip(times_s, wanted_N, strict=True)]
    lines = ["time_s,force_mN", *rows, f"{times_s[-1] + HALF_S:g},0"]
    (folder / "force.csv").write_text("\n".join(lines) + "\n")
    return made


@cache
def _designed(method: Method) -> tuple[LinearSheet, LoopDesign]:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "model.toml"
        save_model(model(load_cell=True), path)
        sheet = linear_sheet(path, "long", 0.0)
        return sheet, design_loop(sheet, goal(method), path)


def _run(folder: Path) -> tuple[int, np.ndarray, list[tuple[float, float]]]:
    command = ["run", *(str(folder / file) for file in _RIG), "-o", str(folder / "s.h5")]
    command += ["--yes", "--controller", str(folder / "controller.toml")]
    command += ["--reference", str(folder / "force.csv")]
    with spied_output() as writes, redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        code = run(command)
    with open_session(folder / "s.h5") as session:
        return code, session.runs[0].control["force_N"].copy(), writes

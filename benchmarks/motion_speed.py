"""The moving sheet: how many times faster than real time, and than other solvers, in CPU time.

A session's pulses in contact, a frame of 40 ms as the live page asks for it, and a sheet let go
from a deflection of 30 mm by labrig, by scipy's `solve_ivp` on the same equations in NumPy, and by
Exudyn (C++, ANCF cable elements) in the peers' environment, all in one run.
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import json
import subprocess
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.overhead_per_reading import peers_python
from benchmarks.report import Report, Table
from model.dynamics import UNDRIVEN, ContactSetup, HeldVoltage, Resolution, Simulation, simulate
from model.dynamics.space import dense
from tests.model.dynamics.cases import (
    B,
    L,
    R,
    driven,
    material,
    plain,
    table,
    under_tip_load,
)

PULSE_S, PULSES = 0.6, 20
DRIVE = HeldVoltage(
    0.5 + PULSE_S * np.arange(PULSES + 1), np.array([2.0, -2.0] * (PULSES // 2) + [0.0])
)
LONG_S = 13.0
SETUP = ContactSetup(radius_m=R, position_m=0.0)
ROUGH = Resolution(tolerance_per_s2=1.0, keep=50)
FEW = replace(ROUGH, degrees=(6, 2))
EVEN = {"after_edges": 1}
CASES = {
    "8+3, 1 ms": ROUGH,
    "6+2, 1 ms": FEW,
    "8+3, 1 ms, edges too": replace(ROUGH, **EVEN),
    "6+2, 1 ms, edges too": replace(FEW, **EVEN),
    "6+2, 0.5 ms": replace(FEW, step_s=5e-4, **EVEN),
    "8+3, 0.5 ms": replace(ROUGH, step_s=5e-4, **EVEN),
}
# scipy's methods and their tolerances, relative and absolute
DEFAULT = {"rtol": 1e-3, "atol": 1e-6}  # what solve_ivp takes where none is given
SOLVERS = (
    *(
        (method, {"rtol": both, "atol": both})
        for both in (1e-1, 1e-2, 1e-4)
        for method in ("LSODA", "BDF", "Radau")
    ),
    *((method, DEFAULT) for method in ("LSODA", "BDF", "Radau", "DOP853", "RK45")),
)
STEPS_S = (4e-3, 3e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 6.25e-5, 2.5e-5)
ERRORS = (1e-3, 1e-4, 1e-5, 1e-6)  # of the tip over l: who is fastest within each
CONVERGED = Resolution(
    after_edges=1, degrees=(12, 6), step_s=1e-4, tolerance_per_s2=1e-3, line_terms=16
)


def session() -> tuple[Table, dict[str, Any]]:
    times = np.arange(0.0, LONG_S, 1e-3)
    exact = simulate(driven(), SETUP, DRIVE, times, resolution=CONVERGED).force_N
    rows, figures = [], {}
    for name, by in CASES.items():
        seconds, force = np.inf, exact
        for _ in range(5):
            began = time.process_time()
            force = simulate(driven(), SETUP, DRIVE, times, s_m=np.zeros(0), resolution=by).force_N
            seconds = min(seconds, time.process_time() - began)
        error = np.abs(force - exact) / np.ptp(exact)
        rms = float(np.sqrt(np.mean(error**2)))
        figures[name] = {"times": LONG_S / seconds, "rms": rms, "largest": float(error.max())}
        rows.append((
            name, f"{seconds * 1e3:.0f} ms", f"{LONG_S / seconds:.0f}", f"{rms:.1e}",
            f"{error.max():.1e}",
        ))  # fmt: skip
    columns = ("resolution", "CPU", "faster than real", "RMS error of F / range", "largest")
    title = f"{LONG_S:g} s of pulses in contact, F at every millisecond"
    return Table(title, columns, tuple(rows)), figures


def live() -> tuple[Table, dict[str, Any]]:
    rows, figures = [], {}
    s = np.linspace(0.0, L, 21)
    for name in ("8+3, 1 ms", "6+2, 1 ms"):
        one = Simulation(driven(), SETUP, DRIVE, resolution=CASES[name])
        spent = []
        for frame in range(1, 300):
            began = time.process_time()
            one.advance(DRIVE, np.array([0.04 * frame]), s)
            spent.append(time.process_time() - began)
        figures[name] = float(np.median(spent))
        rows.append((name, f"{np.median(spent) * 1e3:.2f} ms", f"{np.max(spent) * 1e3:.2f} ms"))
    columns = ("resolution", "CPU, median", "largest")
    return Table("A live frame: 40 ms, force and shape", columns, tuple(rows)), figures


class Equations:
    """The free, straight sheet with Kelvin-Voigt loss in NumPy: M(q) q'' = f(q, q')."""

    def __init__(self, degrees: int, eta: float) -> None:
        one = Simulation(
            plain(material=material(prony=False, eta=eta)), None, UNDRIVEN,
            released_from=under_tip_load(), resolution=Resolution(free_degrees=degrees),
        )  # fmt: skip
        body, bends = one.body, one.body.space.first_node[1]
        angle, position = dense(body.space)
        self.angle, self.position = angle[:bends], position[:bends, :bends]
        self.root_mass = np.sqrt(body.mass[:bends])[:, None]
        self.stiffness, self.eta, self.q = body.stiffness, eta, one.state.q.copy()
        self.end = body.space.weight_m[:bends]

    def rates(self, _: float, y: np.ndarray) -> np.ndarray:
        q, v = np.split(y, 2)
        phi, spin = self.angle @ q, self.angle @ v
        cos, sin = np.cos(phi), np.sin(phi)
        moved = self.root_mass * (
            self.position
            @ np.hstack([-sin[:, None] * self.angle, (-cos * spin**2)[:, None],
                         cos[:, None] * self.angle, (-sin * spin**2)[:, None]])
        )  # fmt: skip
        n = len(q)
        X, ax, Y, ay = moved[:, :n], moved[:, n], moved[:, n + 1 : -1], moved[:, -1]
        force = -self.stiffness * (q + self.eta * v) - X.T @ ax - Y.T @ ay
        return np.concatenate([v, np.linalg.solve(X.T @ X + Y.T @ Y, force)])

    def tip_y(self, q: np.ndarray) -> np.ndarray:
        return np.asarray(np.sin(q @ self.angle.T) @ self.end)


def equal_error(figures: dict[str, dict[str, float]]) -> Table:
    """Return the fastest of each within an error: times depend on it, ratios too."""
    rows = []
    for most in ERRORS:
        within = {name: one for name, one in figures.items() if one["error"] <= most}
        fastest = {}
        for who in ("labrig", "solve_ivp", "Exudyn"):
            own = [(one["seconds"], name) for name, one in within.items() if name.startswith(who)]
            fastest[who] = min(own, default=(np.nan, "none is as near"))
        ours = fastest.pop("labrig")
        cells = (f"{name}, {s * 1e3:.1f} ms: {s / ours[0]:.0f}" for s, name in fastest.values())
        rows.append((f"{most:.0e}", f"{ours[1]}, {ours[0] * 1e3:.2f} ms", *cells))
    columns = ("error within", "labrig", "solve_ivp, times as long", "Exudyn, times as long")
    return Table("The fastest at equal error", columns, tuple(rows))


def release() -> tuple[Table, dict[str, Any], tuple[str, ...]]:
    rows = table("ix_release_from_tip_load.csv")
    rows = rows[rows["t_s"] <= 0.3]
    times, exact, eta = rows["t_s"], rows["tip_y_m"], 2e-3
    found: dict[str, dict[str, Any]] = {}
    for step_s in STEPS_S:
        found[f"labrig, 6 coefficients, {step_s * 1e3:g} ms"] = _own(times, 6, step_s, eta)
    of = Equations(6, eta)
    start = np.concatenate([of.q, np.zeros(6)])
    for method, tolerances in SOLVERS:
        asked = "default" if tolerances is DEFAULT else f"{tolerances['rtol']:.0e}"
        seconds = np.inf
        for _ in range(3):
            began = time.process_time()
            solved = solve_ivp(
                of.rates, (0.0, 0.3), start, method=method, t_eval=times, **tolerances
            )
            seconds = min(seconds, time.process_time() - began)
        found[f"solve_ivp, {method}, {asked}"] = {
            "tip_y_m": of.tip_y(solved.y[:6].T), "seconds": seconds
        }  # fmt: skip
    found |= _exudyn(times, eta)
    notes, lines, figures = [], [], {}
    for name, one in found.items():
        if "why" in one:
            notes.append(f"{name}: not measured, {one['why']}")
            continue
        error = float(np.max(np.abs(np.asarray(one["tip_y_m"]) - exact)) / L)
        figures[name] = {"seconds": one["seconds"], "error": error}
    for name, one in figures.items():
        # labrig's fastest run that is at least as near
        near = [
            f for n, f in figures.items() if n.startswith("labrig") and f["error"] <= one["error"]
        ]
        ratio = one["seconds"] / min(f["seconds"] for f in near) if near else float("nan")
        lines.append(
            (name, f"{one['seconds'] * 1e3:.2f} ms", f"{one['error']:.1e}", f"{ratio:.0f}")
        )
    columns = ("", "CPU", "error of the tip / l", "over labrig at no larger error")
    title = "Let go from 30 mm, 0.3 s (the motion alone)"
    return Table(title, columns, tuple(lines)), figures, tuple(notes)


def _own(times: np.ndarray, degrees: int, step_s: float, eta: float) -> dict[str, Any]:
    beam, held = plain(material=material(prony=False, eta=eta)), under_tip_load()
    by = Resolution(step_s=step_s, free_degrees=degrees, tolerance_per_s2=10.0, rho=0.9)
    best, tip = np.inf, times
    for _ in range(20):
        one = Simulation(beam, None, UNDRIVEN, released_from=held, resolution=by)
        began = time.process_time()
        tip = one.advance(UNDRIVEN, times, np.array([L])).y_m[:, 0]
        best = min(best, time.process_time() - began)
    return {"tip_y_m": tip, "seconds": best}


def _exudyn(times: np.ndarray, eta: float) -> dict[str, dict[str, Any]]:
    given = {
        "B": B, "mu": 5.775e-3, "l": L, "eta": eta, "load": 3.0 * B / L**2,
        "times_s": times.tolist(),
    }  # fmt: skip
    try:
        done = subprocess.run(
            [str(peers_python()), str(Path(__file__).parent / "_motion_peers.py")],
            input=json.dumps(given), capture_output=True, text=True, check=True,
        )  # fmt: skip
    except (OSError, subprocess.CalledProcessError) as error:
        return {"Exudyn": {"why": f"its environment cannot be made ({error})"}}
    last = [line for line in done.stdout.splitlines() if line.startswith("{")][-1]
    found: dict[str, dict[str, Any]] = json.loads(last)
    return found


def measure() -> Report:
    """About a minute; longer when the peers' environment is made."""
    pulses, one = session()
    frames, two = live()
    freed, three, notes = release()
    figures = {"session": one, "live": two, "release": three}
    return Report((pulses, frames, freed, equal_error(three)), figures, notes)


if __name__ == "__main__":
    print(measure().text())

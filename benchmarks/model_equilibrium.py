"""One equilibrium of the sheet against scipy's solve_bvp, in one run on one machine.

Times are CPU times of this process, so that a busy machine changes the ratios little; only the
gain from a second core is measured on the clock. solve_bvp gets the same scaled problem, 11 mesh
points and the free shape's crossing as its start, at a tolerance of 1e-6.
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.integrate import solve_bvp

from benchmarks.report import Report, Table
from model.mechanics.equilibrium import Problems, SolverStatus, nodes_for, problems, solve
from model.mechanics.field import Field
from model.mechanics.free_shape import free_shape

R = 0.04
CASES = {"long sheet": (0.05, 0.0, 0.0, 40.0), "short sheet": (0.0045, 0.04, 0.0, 80.0)}
STEPS = {"long sheet": 3.1, "short sheet": 2.6}  # Newton steps, counted in the compiled engine
START = """
import time; a = time.process_time()
import model; b = time.process_time()
from model.mechanics.equilibrium import problems, solve
from model.mechanics.field import Field
solve(problems(Field.constant(20.0, 0.05), 0.3, 0.04)).shapes([0.0, 0.01]); c = time.process_time()
print(b - a, c - b)
"""


def cpu(function: Callable[[], object], repeats: int) -> float:
    """Least CPU seconds of one call among five rounds."""
    best = np.inf
    for _ in range(5):
        start = time.process_time()
        for _ in range(repeats):
            function()
        best = min(best, (time.process_time() - start) / repeats)
    return float(best)


def batch(name: str, count: int, seed: int = 0) -> Problems:
    """Random problems of the paper's range with constant free curvature."""
    length, elongation, low, high = CASES[name]
    random = np.random.default_rng(seed)
    p, kappa = random.uniform(0.0, 0.03, count), random.uniform(low, high, count)
    one = problems(Field.constant(high, length), p[:1] / R, R, elongation)
    rows = np.repeat(kappa[:, None, None], len(one.breaks_m) - 1, axis=1)
    return replace(one, kappa=np.ascontiguousarray(rows), angle_rad=p / R)


def by_scipy(
    kappa: float, length: float, beta: float, tolerance: float = 1e-6
) -> tuple[float, bool]:
    """N R^2 / B with solve_bvp; unknown besides the shape: nu, s_hat, phi_hat."""
    s = np.linspace(0.0, 0.07, 141)
    x, y, phi = free_shape(Field.constant(kappa, length), s)
    i = int(np.argmax(np.hypot(x, y) >= R))
    share = 1.0 - max(0.0, 1.0 - length / R) ** 3
    nu = 3.0 * (np.arctan2(y[i], x[i]) - beta) / share

    def rates(t, u, p):
        end = min(length, p[1] * R) / R
        lever = (np.cos(beta) - u[1]) * np.cos(p[2]) + (np.sin(beta) - u[2]) * np.sin(p[2])
        bend = np.full_like(t, kappa * R) - p[0] * lever
        return end * np.stack([bend, np.cos(u[0]), np.sin(u[0])])

    def ends(a, b, p):
        beyond = max(p[1] - length / R, 0.0)
        cx, cy = b[1] + beyond * np.cos(p[2]), b[2] + beyond * np.sin(p[2])
        return np.array([*a, cx - np.cos(beta), cy - np.sin(beta), b[0] - p[2]])

    t = np.linspace(0.0, 1.0, 11)
    at = t * min(length, s[i])
    guess = np.stack([np.interp(at, s, v) for v in (phi, x / R, y / R)])
    found = solve_bvp(rates, ends, t, guess, p=[nu, s[i] / R, phi[i]], tol=tolerance)
    return float(found.p[0]), bool(found.success)


def by_itself(code: str) -> list[float]:
    """Numbers printed by code in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True,
        cwd=Path(__file__).parents[1],
    )  # fmt: skip
    return [float(word) for word in done.stdout.split()]


def matrix_rate() -> float:
    """Floating-point operations a second of this machine in matrix products of one thread."""
    code = (
        "import time, numpy as np\nA = np.random.default_rng(0).standard_normal((192, 192))\n"
        "times = []\n"
        "for _ in range(300):\n"
        "    a = time.perf_counter(); A @ A; times.append(time.perf_counter() - a)\n"
        "print(2.0 * 192**3 / min(times))"
    )
    return by_itself(code)[0]


def operations(name: str, nodes: int) -> float:
    """Of one cold solution by collocation, at the least.

    A step: three matrix-vector products, elimination, three right-hand sides, sine and cosine and
    what else there is at a node. The start: where the free shape meets the arc, in four pieces.
    """
    n = nodes
    step = 2 * 3 * n * n + 2 * n**3 / 3 + 3 * 2 * n * n + 60 * n
    return STEPS[name] * step + 4 * 45 * n


def measure() -> Report:
    """All of it; about a minute."""
    rows, figures = [], {}
    rate = matrix_rate()
    for name, (length, elongation, _, _) in CASES.items():
        few, many = batch(name, 60), batch(name, 20_000)
        solve(many)
        answers = [by_scipy(few.kappa[k, 0, 0], length, few.angle_rad[k]) for k in range(60)]
        ours = solve(few).nu * R * R
        off = max(abs(a - o) for (a, good), o in zip(answers, ours, strict=True) if good)
        scipy_s = cpu(lambda few=few, length=length: _all_by_scipy(few, length), 1) / 60
        field = Field.constant(20.0, length)
        single = cpu(lambda f=field, e=elongation: solve(problems(f, 0.3, R, e)), 100)
        batched = cpu(lambda m=many: solve(m), 1) / len(many)
        small = batch(name, 500)
        twin = cpu(lambda b=small: solve(b, engine="numpy"), 1) / len(small)
        floor = operations(name, nodes_for(many)) / rate
        both = cpu(lambda m=many: solve(m, workers=2), 1) / len(many)
        clock = [_clock(lambda m=many, n=n: solve(m, workers=n)) for n in (1, 2)]
        figures[name] = {
            "solve_bvp_s": scipy_s, "single_s": single, "batch_s": batched, "numpy_s": twin,
            "floor_s": floor, "two_threads_gain": clock[0] / clock[1],
            "two_threads_cpu": both / batched, "difference": off,
            "solve_bvp_converged": sum(good for _, good in answers) / 60,
        }  # fmt: skip
        rows.append((
            name, f"{scipy_s * 1e3:.1f} ms", f"{single * 1e6:.0f} µs", f"{scipy_s / single:.0f}",
            f"{batched * 1e6:.1f} µs", f"{scipy_s / batched:.0f}", f"{twin * 1e6:.0f} µs",
            f"{batched / floor:.0f}", f"{clock[0] / clock[1]:.2f} ({both / batched:.2f})",
            f"{off:.0e}",
        ))  # fmt: skip
    columns = (
        "problem", "solve_bvp 1e-6", "one, from Python", "ratio", "in a batch", "ratio",
        "NumPy twin", "over floor", "two threads", "largest difference in N R^2/B",
    )  # fmt: skip
    sure = _robust()
    notes = [f"{text}: {value}" for text, value in sure.items()]
    notes.append(f"floor: operations counted, at {rate / 1e9:.1f} Gflop/s in matrix products")
    notes.append(
        "two threads: gain of workers=2 over 1 on 20 000 problems, on the clock (CPU time of both"
        " over that of one)"
    )
    start = [by_itself(START) for _ in range(4)][1:]  # the first may have to compile
    imported, called = (min(column) for column in zip(*start, strict=True))
    notes.append(
        f"CPU time of `import model` {imported:.2f} s; then of the first equilibrium and its shape,"
        f" code kept from before, {called:.2f} s"
    )
    sure |= {"import_s": f"{imported:.3f}", "first_call_s": f"{called:.3f}"}
    table = Table("Equilibrium of a sheet", columns, tuple(rows))
    return Report((table,), {**figures, **sure}, tuple(notes))


def _all_by_scipy(few: Problems, length: float) -> None:
    for k in range(len(few)):
        by_scipy(few.kappa[k, 0, 0], length, few.angle_rad[k])


def _clock(function: Callable[[], object]) -> float:
    best = np.inf
    for _ in range(40):  # the least: other programs want the cores too
        start = time.perf_counter()
        function()
        best = min(best, time.perf_counter() - start)
    return float(best)


def _robust() -> dict[str, str]:
    """Random problems of the paper's range and an extreme set, all from cold."""
    result = {}
    for name in CASES:
        found = solve(batch(name, 10_000, 1))
        good = int(np.count_nonzero(found.status == SolverStatus.SOLVED))
        same = _same_branch(name, 1000)
        way = "followed step by step from the free shape"
        result[f"{name}, 10000 random problems"] = (
            f"{good} solved; {same} of 1000 on the branch {way}"
        )
    random = np.random.default_rng(2)
    for length in (0.0045, 0.02, 0.05):
        kappa, p = random.uniform(-150.0, 150.0, 1000), random.uniform(-0.06, 0.066, 1000)
        found = solve(problems([Field.constant(k, length) for k in kappa], p / R, R, 10.0))
        good = int(np.count_nonzero(found.status == SolverStatus.SOLVED))
        result[f"extreme, {length * 1e3:g} mm"] = f"{good} of 1000 solved"
    return result


def _same_branch(name: str, count: int) -> int:
    """How many agree with a continuation in 60 steps from where the free shape meets the arc."""
    cold = batch(name, count, 1)
    length = cold.length_m
    s = np.linspace(0.0, 0.2, 4001)
    start = np.empty(count)
    for k in range(count):
        x, y, _ = free_shape(Field.constant(cold.kappa[k, 0, 0], length), s)
        i = int(np.argmax(np.hypot(x, y) >= R))
        start[k] = np.arctan2(y[i], x[i])
    walked = None
    for share in np.linspace(0.0, 1.0, 61):
        angle = (1.0 - share) * start + share * cold.angle_rad
        walked = solve(replace(cold, angle_rad=angle, reach_m=10.0), walked)
    found = solve(cold)
    return int(np.count_nonzero(np.abs(found.nu - walked.nu) * R * R < 1e-6))

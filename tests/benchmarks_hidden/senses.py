"""What each hidden effect does to the data, in words as numbers: positive is as its name says."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.hidden_effects.visits import POSITIONS_M
from model import Condition, Measurements

FIRST, LAST = POSITIONS_M[0], POSITIONS_M[-1]
Number = Callable[[Measurements], float]


def at(m: Measurements, name: str, position_m: float, volts: float) -> Condition:
    """The first condition measured there."""
    key = (name, position_m, volts)
    return next(c for c in m.conditions if (c.configuration, c.position_m, c.voltage_V) == key)


def force(m: Measurements, name: str, position_m: float, volts: float) -> float:
    """Mean, mN."""
    return float(np.mean([r.force_N for r in at(m, name, position_m, volts).used()])) * 1e3


def all_forces(m: Measurements) -> np.ndarray:
    """Means of all conditions, mN, in the order of the runs."""
    return np.array([np.mean([r.force_N for r in c.used()]) * 1e3 for c in m.conditions])


def slope(name: str, volts: float = 0.0) -> Number:
    """By how much the force falls along the arc."""
    return lambda m: force(m, name, FIRST, volts) - force(m, name, LAST, volts)


def swing(name: str, position_m: float = FIRST) -> Number:
    """Difference of force between the polarities."""
    return lambda m: force(m, name, position_m, 2.0) - force(m, name, position_m, -2.0)


def swings_kept(m: Measurements) -> np.ndarray:
    """The same pulse by pulse, of the short sheet at 0 mm."""
    up, down = (at(m, "short", FIRST, v).used() for v in (2.0, -2.0))
    return np.array([a.force_N - b.force_N for a, b in zip(up, down, strict=True)]) * 1e3


def first_swing(m: Measurements) -> float:
    """Of the two discarded pulses."""
    first = [at(m, "short", FIRST, v).readings[0] for v in (2.0, -2.0)]
    assert all(r.kind == "discarded" for r in first)
    return (first[0].force_N - first[1].force_N) * 1e3


def zeros(m: Measurements, name: str = "long") -> np.ndarray:
    """Readings at 0 V and 0 mm, mN."""
    return np.array([r.force_N * 1e3 for r in at(m, name, FIRST, 0.0).used()])


def turn(m: Measurements, volts: float, from_mm: float, to_mm: float, at_m: float = 0.0) -> float:
    """By how much the long sheet turns between two places, rad."""
    c = at(m, "long", at_m, volts).curve
    assert c is not None
    middle_mm = (c.s_m[1:] + c.s_m[:-1]) / 2 * 1e3
    angle = np.unwrap(np.arctan2(np.diff(c.y_m), np.diff(c.x_m)))
    low, high = (np.mean(angle[np.abs(middle_mm - where) < 2.0]) for where in (from_mm, to_mm))
    return float(high - low)


def reach(m: Measurements, along: int = 0, name: str = "long") -> float:
    """How far the mean curve at 0 mm and 0 V extends, along x (0) or y (1), mm."""
    c = at(m, name, LAST if along else FIRST, 0.0).curve
    assert c is not None
    return float(np.max((c.x_m, c.y_m)[along])) * 1e3


def height(m: Measurements, volts: float) -> float:
    """y of the long sheet's end at 0 mm, mm."""
    c = at(m, "long", FIRST, volts).curve
    assert c is not None
    return float(c.y_m[-1]) * 1e3


def in_pulse(m: Measurements) -> float:
    """Mean swing of the short sheet early in the pulses, less that at the sampling point, mN."""
    series = next(s for s in m.series if (s.configuration, s.position_m) == ("short", FIRST))
    assert series.force_N is not None
    pulse = np.floor(series.time_s / 0.6).astype(int)
    since = series.time_s - 0.6 * pulse
    means = []
    for low, high in ((0.15, 0.25), (0.45, 0.55)):
        now = (since > low) & (since < high) & (pulse >= 12)
        up, down = (now & (np.sign(series.drive_V) == s) for s in (1, -1))
        means.append(series.force_N[up].mean() - series.force_N[down].mean())
    return float(means[0] - means[1]) * 1e3


def mean_force(m: Measurements) -> float:
    return float(all_forces(m).mean())


def less(number: Number) -> Number:
    return lambda m: -number(m)


# By effect: what grows when the effect is there with the size it is hidden with.
SENSES: dict[str, Number] = {
    # more of the bending is near the clamp
    "nonuniform_eibm": lambda m: turn(m, 2, 2, 20, 0.015) - turn(m, -2, 2, 20, 0.015),
    "initial_curvature": lambda m: turn(m, 0, 2, 48),
    "eibm_asymmetry": lambda m: (
        (force(m, "short", FIRST, 2) - force(m, "short", FIRST, 0))
        / (force(m, "short", FIRST, 0) - force(m, "short", FIRST, -2))
    ),
    "nonuniform_stiffness": less(slope("long")),  # softer where the load bends it most
    "nonlinear_stiffness": slope("long"),
    "stiffness_drift": slope("long", 2.0),
    "eibm_drift": less(lambda m: float(swings_kept(m)[-3:].mean() - swings_kept(m)[:3].mean())),
    "viscoelastic_creep": less(lambda m: float(zeros(m)[-3:].mean() - zeros(m)[:3].mean())),
    "charging_lag": less(swing("short")),
    "back_relaxation": in_pulse,
    "first_pulse_transient": lambda m: float(swings_kept(m)[-3:].mean()) - first_swing(m),
    "elongation_flexibility": less(slope("short")),
    "gravity": less(lambda m: force(m, "long", FIRST, 0)),
    "surface_tension": lambda m: force(m, "short", FIRST, 0) - force(m, "long", FIRST, 0),
    "clamp_compliance": less(slope("long")),
    "clamp_angle": lambda m: force(m, "long", FIRST, 0),
    "roll_friction": less(swing("long", LAST)),
    "roll_sticking": less(swing("short", LAST)),
    "roll_offset": lambda m: force(m, "long", FIRST, 0),
    "force_offset": mean_force,
    "force_drift": lambda m: float(all_forces(m)[-6:].mean() - all_forces(m)[:6].mean()),
    "load_cell_misalignment": less(lambda m: force(m, "long", LAST, 0)),
    "load_cell_hysteresis": less(swing("short")),
    "load_cell_compliance": less(slope("short")),
    "position_error": less(lambda m: force(m, "short", 0.015, 0)),
    "camera_scale": reach,
    "camera_roll": lambda m: reach(m, 1),
    "camera_perspective": lambda m: reach(m) + reach(m, 1),
    "frame_delay": less(lambda m: height(m, 2) - height(m, -2)),  # seen is the pulse before
    # outside the catalogue
    "local_rest_curvature": lambda m: turn(m, 0, 16, 28),
    "local_eibm": lambda m: turn(m, 2, 20, 40) - turn(m, -2, 20, 40),
    "dead_electrode": less(lambda m: turn(m, 2, 4, 20) - turn(m, -2, 4, 20)),
    "even_moment_patch": lambda m: turn(m, 2, 8, 28) + turn(m, -2, 8, 28) - 2 * turn(m, 0, 8, 28),
    "stiff_patch": slope("long"),
    "crack": less(slope("long")),
    "screw_error": lambda m: force(m, "short", 0.01, 0) - force(m, "short", 0.005, 0),
    "slipped_stage": less(lambda m: force(m, "short", LAST, 0) - force(m, "short", FIRST, 0)),
    "cable_pull": lambda m: force(m, "long", LAST, 0) - force(m, "long", FIRST, 0),
    "voltage_pickup": swing("short"),
    "beating_cell": lambda m: float(np.std(zeros(m))),
    "breathing_eibm": lambda m: float(np.std(swings_kept(m))),
    "dented_lens": lambda m: reach(m, 1),
}

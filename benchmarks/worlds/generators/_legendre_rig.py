"""What the world `legendre` hides that the catalogue has: rolls, load cell, stage and camera."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators import _legendre_course as course
from benchmarks.worlds.generators._legendre_ritz import Array
from benchmarks.worlds.session.effects import Acting, Image, Load, acting
from benchmarks.worlds.session.layout import Samples

STICKS_FROM_M, LOOPS = 0.0174, (0.25, 0.75)
DEAD_M = 1e-5


def rubs(contact_m: Array, at: Samples, size: float) -> Array:
    """Return the rolls' drag over the normal force: against the way the sheet last slid.

    A contact that goes towards the sheet's end is a sheet that slides towards the clamp.
    """
    return np.asarray(size * course.slid(contact_m, at, DEAD_M))


def stuck(load: Load, size: float) -> Array:
    """Far out the sheet is stuck until the force has changed by `size` in mN."""
    far = np.nan_to_num(load.position_m, nan=-1.0) > STICKS_FROM_M
    return np.where(far, course.play(load, 1e-3 * size), load.force_N)


def loops(load: Load, size: float) -> Array:
    """A cell whose glue has two plays in a row, so that its loop has round corners."""
    parts = [0.5 * course.play(load, 2e-3 * size * share) for share in LOOPS]
    return np.asarray(sum(parts))


def turned(load: Load, size: float) -> Array:
    """The cell's axis is turned by `size`."""
    touched = np.isfinite(load.position_m)
    return np.where(touched, load.outward_N * np.cos(load.lean_rad - size), load.force_N)


def meniscus(load: Load, size: float) -> Array:
    """Water in the rolls pulls along the sheet's normal."""
    pull = 1e-3 * size * np.cos(load.lean_rad)
    return np.asarray(load.force_N + np.where(np.isfinite(load.position_m), pull, 0.0))


def zero(load: Load, size: float) -> Array:
    """The zero is wrong."""
    return np.asarray(load.force_N + 1e-3 * size)


def rising(load: Load, size: float) -> Array:
    """The zero rises with the session's time."""
    return np.asarray(load.force_N + 1e-3 * size * load.samples.tau)


def settling(load: Load, size: float) -> Array:
    """The zero settles within a fourth of the session, as electronics do that were switched on."""
    return np.asarray(load.force_N - 1e-3 * size * np.expm1(-4.0 * load.samples.tau))


def larger(image: Image, size: float) -> tuple[Array, Array]:
    """Lengths are too long."""
    return (1.0 + size) * image.x_m, (1.0 + size) * image.y_m


def higher(image: Image, size: float) -> tuple[Array, Array]:
    """Pixels are not square."""
    return image.x_m, (1.0 + size) * image.y_m


def rolled(image: Image, size: float) -> tuple[Array, Array]:
    """The camera is turned about its axis."""
    c, s = np.cos(size), np.sin(size)
    return c * image.x_m - s * image.y_m, s * image.x_m + c * image.y_m


def leaning(image: Image, size: float) -> tuple[Array, Array]:
    """The camera looks askew, 30 degrees off x."""
    u = np.cos(np.pi / 6) * image.x_m + np.sin(np.pi / 6) * image.y_m
    depth = 1.0 - size * u / 50e-3
    return image.x_m / depth, image.y_m / depth


RIG: dict[str, Acting] = {
    "other_radius": acting(
        "The cell's arm is c longer than stated; positions are lengths on its arc.", "arc_error",
        ("position",), (0.3, 5.0), "mm", setting=lambda c: {"radius_m": 1e-3 * c},
        parameters=lambda c: {"offset_mm": c, "of": 0.0}),
    "stands_farther": acting(
        "The cell stands c farther along the arc than stated.", "position_error", ("position",),
        (0.3, 6.0), "mm", cases=course.place(lambda p, _, c: c + 0.0 * p),
        parameters=lambda c: {"offset_mm": c, "scale": 0.0}),
    "stage_gear": acting(
        "The stage goes too far, by c at 30 mm and in proportion.", "position_error",
        ("position",), (0.4, 6.0), "mm", cases=course.place(lambda p, _, c: c * p / 30.0),
        parameters=lambda c: {"offset_mm": c, "scale": 1.0}),
    "rolls_rub": acting(
        "The rolls' bearings drag on the sheet with c |N|, against the way it last slid by 10 um;"
        " placed, it slid towards the clamp.", "roll_friction", ("position", "load_cell"),
        (0.08, 0.7), "-", setting=lambda _: {"friction": 1.0}, slides=rubs),
    "thick_roll": acting(
        "The sheet passes beside the arc's point, c along its normal.", "roll_offset",
        ("position",), (0.3, 3.0), "mm", setting=lambda c: {"beside_m": 1e-3 * c},
        parameters=lambda c: {"offset_mm": c, "at_the_pressed": 0.0}),
    "sticks_far_out": acting(
        "From 17.5 mm on the sheet is stuck in the rolls: the force follows with a play of c.",
        "roll_sticking", ("position", "load_cell"), (0.15, 2.0), "mN", force=stuck),
    "wrong_zero": acting(
        "The cell's zero is c.", "force_offset", ("load_cell",), (0.06, 4.0), "mN", force=zero,
        parameters=lambda c: {"force_mN": c}),
    "zero_rises": acting(
        "The cell's zero is c tau over the session.", "force_drift", ("load_cell",), (0.12, 5.0),
        "mN", force=rising,
        parameters=lambda c: {"force_mN": c, "settles": 0.0, "tared_at": 0.0}),
    "electronics_warm": acting(
        "The amplifier warms up: its zero is c (1 - exp(-4 tau)) over the session.", "force_drift",
        ("load_cell",), (0.15, 5.0), "mN", force=settling),
    "soft_cell": acting(
        "The cell gives way along its axis, by c times the force.", "load_cell_compliance",
        ("load_cell", "position"), (0.02, 1.5), "mm/mN", setting=lambda c: {"cell_m_per_N": c},
        parameters=lambda c: {"compliance_mm_per_mN": c}),
    "glued_cell": acting(
        "The gauges' glue creeps: the force follows with two plays in a row, c/2 and 3 c/2.",
        "load_cell_hysteresis", ("load_cell",), (0.08, 1.0), "mN", force=loops),
    "turned_cell": acting(
        "The cell's axis is turned by c: it shows N cos(gamma - c).", "load_cell_misalignment",
        ("load_cell",), (0.06, 0.6), "rad", force=turned, parameters=lambda c: {"angle_rad": c}),
    "wet_rolls": acting(
        "A meniscus in the rolls of either sheet pulls with c along the sheet's normal.",
        "surface_tension", ("load_cell",), (0.1, 3.0), "mN", force=meniscus),
    "wrong_scale": acting(
        "Lengths in the picture are 1 + c of the true ones.", "camera_scale", ("camera",),
        (0.005, 0.25), "-", image=larger, parameters=lambda c: {"relative_error": c, "axis": 0.0}),
    "oblong_pixels": acting(
        "Only heights in the picture are 1 + c of the true ones.", "camera_scale", ("camera",),
        (0.006, 0.25), "-", image=higher, parameters=lambda c: {"relative_error": c, "axis": 1.0}),
    "rolled_camera": acting(
        "The picture is turned by c.", "camera_roll", ("camera",), (0.008, 0.2), "rad",
        image=rolled, parameters=lambda c: {"angle_rad": c}),
    "leaning_camera": acting(
        "The picture is r/(1 - c u/50 mm), u 30 degrees off x.", "camera_perspective",
        ("camera",), (0.006, 0.25), "-", image=leaning),
    "late_picture": acting(
        "A picture is c older than its reading.", "frame_delay", ("camera", "time"),
        (0.3, 0.49), "s", delay_s=lambda c: c, parameters=lambda c: {"delay_s": c}),
}  # fmt: skip

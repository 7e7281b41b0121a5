"""What the world `legendre` hides that no catalogue has: rolls, load cell, stage and camera."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators import _legendre_course as course
from benchmarks.worlds.generators._legendre_plant import Framed
from benchmarks.worlds.generators._legendre_ritz import Array
from benchmarks.worlds.session.effects import Acting, Load, acting
from benchmarks.worlds.session.layout import Samples

FILM_S, KICK_S, WARM_S = 8.5, 0.18, 5.0


def uneven_gain(load: Load, size: float) -> Array:
    """One gauge has come half off: the cell shows more when pushed one way than the other."""
    return np.asarray(load.force_N * (1.0 + size * (load.force_N > 0.0)))


def gain_of_place(load: Load, size: float) -> Array:
    """The cell bends its arm, whose lever is another one at each position."""
    place = np.nan_to_num(load.position_m)
    return np.asarray(load.force_N * (1.0 + size * (place / 15e-3 - 1.0)))


def crosstalk(load: Load, size: float) -> Array:
    """The sheet's leads lie beside the bridge's: the drive's voltage leaks into the signal."""
    return np.asarray(load.force_N + 1e-3 * size * load.samples.sheet_V / 2.0)


def kick(load: Load, size: float) -> Array:
    """The edge charges the amplifier's filter, which then runs down."""
    at = load.samples
    step = (at.drive_V - at.before_V) / 4.0
    return np.asarray(load.force_N + 1e-3 * size * step * np.exp(-at.phase_s / KICK_S))


def film_snaps(load: Load, size: float) -> Array:
    """A film of water between roll and sheet pulls until it snaps, 8.5 s after a run's begin."""
    wet = np.isfinite(load.position_m) & (load.samples.time_s < FILM_S)
    return np.asarray(load.force_N + 1e-3 * size * wet)


def bridge_warms(load: Load, size: float) -> Array:
    """The bridge is switched on for each run, and its zero moves as it warms."""
    return np.asarray(load.force_N - 1e-3 * size * np.expm1(-load.samples.time_s / WARM_S))


def lost_steps(place_mm: Array, at: Samples, size: float) -> Array:
    """The motor loses steps as the session goes on: the cell falls short more and more."""
    return np.asarray(-size * at.tau + 0.0 * place_mm)


def bowed_rail(place_mm: Array, _: Samples, size: float) -> Array:
    """The rack's teeth were cut unevenly: the stage is ahead amid its travel."""
    return np.asarray(size * np.sin(np.pi * place_mm / 30.0))


def skewed(image: Framed, size: float) -> tuple[Array, Array]:
    """The mirror is askew: what is higher is seen farther to the side."""
    return image.x_m + size * image.y_m, image.y_m


def halo(image: Framed, size: float) -> tuple[Array, Array]:
    """The lamp at the far end blooms: the edge that is seen moves to one side, more out there."""
    aside = 1e-3 * size * (image.x_m / 50e-3) ** 2
    return image.x_m - aside * np.sin(image.phi_rad), image.y_m + aside * np.cos(image.phi_rad)


def zooming(image: Framed, size: float) -> tuple[Array, Array]:
    """The lens's focus creeps, and lengths with it, over the session."""
    scale = 1.0 + size * (image.samples.tau[:, None] - 0.5)
    return scale * image.x_m, scale * image.y_m


def wall_of_water(image: Framed, size: float) -> tuple[Array, Array]:
    """Seen through a wet window whose film sags: heights are off in a slow wave along x."""
    aside = 1e-3 * size * np.sin(2.0 * np.pi * image.x_m / 45e-3)
    return image.x_m, image.y_m + aside


BEYOND: dict[str, Acting] = {
    "uneven_gain": acting(
        "The cell shows (1 + c) F where F > 0, and F where it is not.", None, ("load_cell",),
        (0.06, 0.8), "-", force=uneven_gain),
    "gain_of_place": acting(
        "The cell shows F (1 + c (p/15 mm - 1)).", None, ("load_cell",), (0.06, 0.7),
        "-", force=gain_of_place),
    "crosstalk": acting(
        "The drive leaks into the bridge: F + c V/2 V.", None, ("load_cell",), (0.06, 2.0), "mN",
        force=crosstalk),
    "filter_kick": acting(
        "After an edge the filter runs down: F + c exp(-t/0.18 s), c for a step of 4 V.", None,
        ("load_cell", "time"), (0.3, 6.0), "mN", ("series",), force=kick),
    "film_snaps": acting(
        "In the first 8.5 s of a run a film of water pulls with c.", None, ("load_cell", "time"),
        (0.15, 3.0), "mN", force=film_snaps),
    "bridge_warms": acting(
        "In each run the zero goes as c (1 - exp(-t/5 s)).", None, ("load_cell", "time"),
        (0.15, 3.0), "mN", force=bridge_warms),
    "eccentric_roll": acting(
        "A roll of 2.5 mm radius is eccentric by c: it is beside the arc by c sin(s_hat/2.5 mm).",
        None, ("position",), (0.25, 1.0), "mm", setting=lambda c: {"eccentric_m": 1e-3 * c}),
    "arc_aside": acting(
        "The arm's axis lies c beside the clamp, towards +y.", None, ("position",), (0.4, 4.0),
        "mm", setting=lambda c: {"arc_y_m": 1e-3 * c}),
    "lost_steps": acting(
        "The stage falls short of its place by c tau over the session.", None,
        ("position", "time"), (0.5, 5.0), "mm", cases=course.place(lost_steps)),
    "uneven_rack": acting(
        "The stage is c sin(pi p/30 mm) ahead.", None, ("position",), (0.4, 4.0), "mm",
        cases=course.place(bowed_rail)),
    "skewed_picture": acting(
        "The picture is skewed: x + c y.", None, ("camera",), (0.01, 0.3), "-", image=skewed),
    "blooming_lamp": acting(
        "The lamp moves the edge that is seen by c (x/50 mm)^2 along the normal.", None,
        ("camera",), (0.15, 2.5), "mm", image=halo),
    "creeping_focus": acting(
        "Lengths in the picture grow by c over the session.", None, ("camera", "time"),
        (0.01, 0.25), "-", image=zooming),
    "wet_window": acting(
        "Heights in the picture are off by c sin(2 pi x/45 mm).", None, ("camera",), (0.1, 2.0),
        "mm", image=wall_of_water),
}  # fmt: skip

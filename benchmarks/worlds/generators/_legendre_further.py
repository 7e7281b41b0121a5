"""What the world `legendre` hides that no catalogue has: sheet and clamp."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators import _legendre_course as course
from benchmarks.worlds.generators._legendre_ritz import Array
from benchmarks.worlds.generators._legendre_specimen import LONG, Specimen
from benchmarks.worlds.generators._legendre_strip import Along, only
from benchmarks.worlds.session.effects import Acting, acting
from benchmarks.worlds.session.layout import Samples

SET_S, HUMID_S, BUBBLE_S = 2.5, 410.0, 3.7


def delaminated(size: float) -> dict[str, Along]:
    """Beyond 27 mm the plating has come off: what is left of the EIBM there is 1 - size."""
    edge = only(LONG, lambda s, _: 0.5 * (1.0 + np.tanh((s - 27e-3) / 2e-3)))
    return {"profile": lambda s, true: 1.0 - size * edge(s, true)}


def cloudy_plating(size: float) -> dict[str, Along]:
    """The plating bath was not stirred: the metal is thick and thin in turn along the sheet."""
    wave = only(LONG, lambda s, _: np.cos(2.0 * np.pi * s / 24e-3))
    return {"profile": lambda s, true: 1.0 + size * wave(s, true)}


def covered(size: float) -> dict[str, Along]:
    """The contact plates reach over the clamp's edge, and keep the water from that part."""
    return {"profile": lambda s, _: 1.0 - size * np.exp(-((s / 3.5e-3) ** 2))}


def hot_end(size: float) -> dict[str, Along]:
    """Heat of the leaking current gathers in the far half, and one face is cooled by the bench."""
    return {"even": lambda s, _: size * (s / s[-1]) ** 2}


def glued(size: float) -> dict[str, Along]:
    """A drop of glue, 7 mm long, has run onto the sheet about 16 mm: B is 1 + size there."""
    drop = only(LONG, lambda s, _: np.exp(-(((s - 16e-3) / 3.5e-3) ** 4)))
    return {"soft": lambda s, true: 1.0 / (1.0 + size * drop(s, true))}


def waisted(size: float) -> dict[str, Along]:
    """The scissors slipped: the sheet is narrower by `size` about its middle, B and EIBM alike."""

    def width(s: Array, _: Specimen) -> Array:
        return np.asarray(1.0 - size * np.sin(np.pi * s / s[-1]) ** 2)

    return {"profile": width, "soft": lambda s, true: 1.0 / width(s, true)}


def from_the_reel(size: float) -> dict[str, Along]:
    """Stored over the edge of a stack, the sheet has a wave at rest."""
    return {"rest": only(LONG, lambda s, _: size * np.sin(2.0 * np.pi * s / 28e-3))}


def curled_end(size: float) -> dict[str, Along]:
    """The far end has dried in air and rolls up."""
    return {"rest": only(LONG, lambda s, _: size / (1.0 + np.exp(-(s - 34e-3) / 2.5e-3)))}


def straightens(at: Samples, size: float) -> Array:
    """The sheet takes up water all the session, and its curvature at rest goes."""
    return np.asarray(-size * (at.tau - 0.5))


def remembers(at: Samples, size: float) -> Array:
    """A part of the bending stays as a set and follows the polarity with 2.5 s."""
    return course.following(at, size * at.drive_V / 2.0, SET_S)


def humid(at: Samples, size: float) -> Array:
    """The room's humidifier switches on and off, and the polymer softens and stiffens with it."""
    return np.asarray(1.0 + size * np.tanh(3.0 * np.sin(2.0 * np.pi * at.session_s / HUMID_S)))


def bubbles(at: Samples, size: float) -> Array:
    """A bubble grows on the electrode, covers it and comes off, again and again."""
    driven = np.where(at.pulse >= 0, at.pulse * course.PULSE_S + at.phase_s, 0.0)
    return np.asarray(1.0 - size * np.mod(driven / BUBBLE_S, 1.0))


def draught(at: Samples, size: float) -> Array:
    """For a sixth of the session a door is open, and the sheet is drier."""
    return np.asarray(1.0 - size * np.exp(-(((at.tau - 0.36) / 0.09) ** 4)))


def ratchet(at: Samples, size: float) -> Array:
    """One electrode wears and the other one forms: +V loses in the session what -V gains."""
    return np.asarray(1.0 - size * (at.tau - 0.5) * np.sign(at.sheet_V))


def weak_source(at: Samples, size: float) -> Array:
    """The negative supply sags with each pulse that it has to give in a run, the other does not."""
    return np.where(at.sheet_V < 0.0, 1.0 - size * np.maximum(at.pulse, 0.0) / 20.0, 1.0)


FURTHER: dict[str, Acting] = {
    "delaminated": acting(
        "Beyond 27 mm the metal has come off: the long sheet's EIBM is 1 - c there.", None,
        ("eibm",), (0.3, 1.0), "-", setting=delaminated),
    "cloudy_plating": acting(
        "Thick and thin metal in turn: the long sheet's EIBM is 1 + c cos(2 pi s/24 mm).", None,
        ("eibm",), (0.2, 2.0), "-", setting=cloudy_plating),
    "covered_root": acting(
        "Contact plates cover the root: the EIBM is 1 - c exp(-(s/3.5 mm)^2).", None, ("eibm",),
        (0.3, 1.0), "-", setting=covered),
    "hot_end": acting(
        "Heat bends the far part one way at either polarity: c (V/2 V)^2 (s/l)^2, over B.", None,
        ("even_moment", "eibm"), (6.0, 40.0), "1/m", setting=hot_end),
    "glue_on_sheet": acting(
        "A drop of glue stiffens the long sheet by 1 + c between 12.5 and 19.5 mm.", None,
        ("compliance",), (0.5, 12.0), "-", setting=glued),
    "waisted": acting(
        "The sheet is narrower by c sin^2(pi s/l): stiffness and EIBM are less alike.", None,
        ("compliance", "eibm"), (0.15, 0.7), "-", setting=waisted),
    "wave_at_rest": acting(
        "The long sheet at rest has a wave, c sin(2 pi s/28 mm).", None, ("rest_curvature",),
        (3.0, 30.0), "1/m", setting=from_the_reel),
    "curled_end": acting(
        "The long sheet's end rolls up, by c beyond 34 mm.", None, ("rest_curvature",),
        (4.0, 25.0), "1/m", setting=curled_end),
    "straightens": acting(
        "The curvature at rest goes down by c over the session.", None, ("rest_curvature", "time"),
        (2.0, 14.0), "1/m", cases=course.rest(straightens)),
    "remembers_bending": acting(
        "A set of c follows the voltage with a lag of 2.5 s, in the curvature at rest.", None,
        ("rest_curvature", "time"), (3.0, 20.0), "1/m", cases=course.rest(remembers)),
    "slid_out": acting(
        "The sheet has slid out of the clamp by c: that much more of it bends.", None,
        ("compliance", "eibm", "rest_curvature"), (0.3, 2.5), "mm",
        setting=lambda c: {"longer": 1e-3 * c}),
    "play_in_clamp": acting(
        "The sheet rattles in the clamp: it leaves it at c tanh(M/20 uN m), M the load's moment.",
        None, ("compliance", "rest_curvature"), (0.02, 0.15), "rad",
        setting=lambda c: {"clamp_play_rad": c}),
    "humidifier": acting(
        "The room is humid and dry in turn: stiffness 1 + c tanh(3 sin(2 pi t/410 s)).", None,
        ("time", "compliance"), (0.06, 0.5), "-", cases=course.stiffness(humid)),
    "bubbles": acting(
        "Bubbles grow and come off: of the EIBM c times the part of 3.7 s gone by is lost.", None,
        ("time", "eibm"), (0.1, 0.8), "-", cases=course.eibm(bubbles)),
    "open_door": acting(
        "A door is open: the EIBM is 1 - c exp(-((tau - 0.36)/0.09)^4).", None, ("time", "eibm"),
        (0.12, 0.8), "-", cases=course.eibm(draught)),
    "ratchet": acting(
        "Over the session the EIBM of +V loses c, that of -V gains it.", None, ("time", "eibm"),
        (0.15, 1.2), "-", cases=course.eibm(ratchet)),
    "sagging_supply": acting(
        "In each run the negative supply sags: the EIBM of pulse k at -V is 1 - c k/20.", None,
        ("time", "eibm"), (0.15, 0.8), "-", cases=course.eibm(weak_source)),
}  # fmt: skip

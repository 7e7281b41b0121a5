"""Kinds that no catalogue has, and where an answer may put them."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.generators._splines_known import MM, MN, Hide
from benchmarks.worlds.generators._splines_rig import Rig
from benchmarks.worlds.generators._splines_sheet import A


def crease(rig: Rig, c: float) -> None:
    """Bend the sheet at one place."""
    for sheet in rig.sheets.values():
        length = sheet.length_m
        sheet.rest.append(
            lambda s, length=length: c * np.exp(-(((s / length - 0.6) / 0.08) ** 2) / 2.0)
        )


def s_bend(rig: Rig, c: float) -> None:
    """Bend one half of the sheet forwards and the other back."""
    for sheet in rig.sheets.values():
        length = sheet.length_m
        sheet.rest.append(lambda s, length=length: c * np.sin(2.0 * np.pi * s / length))


def dry_patch(rig: Rig, c: float) -> None:
    """Take EIBM away between a quarter and a half of the length."""
    for sheet in rig.sheets.values():
        length = sheet.length_m

        def left(s: A, _sign: A, length: float = length) -> A:
            at = s / length
            return 1.0 - c * (np.tanh((at - 0.25) / 0.04) - np.tanh((at - 0.5) / 0.04)) / 2.0

        sheet.profile.append(left)


def strained_gel(rig: Rig, c: float) -> None:
    """Let the EIBM grow with the curvature."""
    for sheet in rig.sheets.values():
        sheet.coupled.append(lambda k: 1.0 + c * np.tanh(k / 80.0))


def warm_electrodes(rig: Rig, c: float) -> None:
    """Bow the outer part of the sheet by the heat of the current, at either voltage."""
    for sheet in rig.sheets.values():
        length = sheet.length_m
        sheet.bowing.append(lambda s, length=length: c * (s / length) ** 2)


def droplet(rig: Rig, c: float) -> None:
    """Pull at one place of the sheet."""
    for sheet in rig.sheets.values():
        at, soft = 0.45 * sheet.length_m, 0.01 * sheet.length_m
        sheet.dead_load.append(
            lambda s, at=at, soft=soft: c * MN / (1.0 + np.exp(np.clip((s - at) / soft, -60, 60)))
        )


def notch(rig: Rig, c: float) -> None:
    """Weaken the sheet at one place."""
    for sheet in rig.sheets.values():
        length = sheet.length_m
        sheet.stiffness.append(
            lambda s, length=length: 1.0 - c * np.exp(-(((s / length - 0.3) / 0.07) ** 2) / 2.0)
        )


def softens_when_driven(rig: Rig, c: float) -> None:
    """Lower the stiffness under voltage."""
    rig.softening.append(lambda alpha: 1.0 - c * np.tanh(2.0 * np.abs(alpha)))


def one_sided(rig: Rig, c: float) -> None:
    """Make the sheet stiffer towards one side than towards the other."""
    for sheet in rig.sheets.values():
        sheet.law = lambda u: u * (1.0 + c * np.tanh(u / 5.0))


def arc_centre(rig: Rig, c: float) -> None:
    """Move the centre of the arc away from the clamp."""
    for sheet in rig.sheets.values():
        sheet.centre_m = (c * MM, 0.0)


def uneven_screw(rig: Rig, c: float) -> None:
    """Let the position go forwards and back with the turn of a screw."""
    rig.place.append(lambda p: p + c * MM * np.sin(2.0 * np.pi * p / 0.0125))


def push_and_pull(rig: Rig, c: float) -> None:
    """Show more of a push than of a pull."""
    rig.cell.append(lambda _run, felt: felt.force_N * (1.0 + c * (felt.force_N > 0.0)))


def warm_hand(rig: Rig, c: float) -> None:
    """Let the zero decay after the load cell was touched."""
    rig.cell.append(lambda run, felt: felt.force_N + c * MN * np.exp(-run.time_s / 4.0))


def barrel(rig: Rig, c: float) -> None:
    """Distort the picture about its middle."""

    def seen(x: A, y: A) -> tuple[A, A]:
        more = 1.0 + c * ((x - 0.02) ** 2 + y**2 - 0.02**2) / 0.025**2
        return 0.02 + (x - 0.02) * more, y * more

    rig.view.append(seen)


def lit_edge(rig: Rig, c: float) -> None:
    """Find the lit edge of the sheet in place of its middle, beyond the clamp's shadow."""

    def seen(x: A, y: A) -> tuple[A, A]:
        way = np.arctan2(np.gradient(y, axis=1), np.gradient(x, axis=1))
        lit = c * MM * (1.0 - np.exp(-np.hypot(x, y) / 0.004))
        return x - lit * np.sin(way), y + lit * np.cos(way)

    rig.view.append(seen)


def supply_beat(rig: Rig, c: float) -> None:
    """Let the EIBM come and go over the session."""
    rig.swing.append(lambda run, alpha: alpha * (1.0 + c * np.sin(2.0 * np.pi * 3.3 * run.share)))


def remanence(rig: Rig, c: float) -> None:
    """Bend the sheet more with each pulse of a run, whatever its sign."""
    rig.warping.append(lambda run: c * (1.0 - np.exp(-(run.pulse + 1.0) / 6.0)))


def _kind(
    words: str, locations: tuple[str, ...], typical: float, largest: float, unit: str
) -> HiddenKind:
    return HiddenKind(
        words=words, known_as=None, locations=locations, typical=typical, largest=largest, unit=unit
    )


KINDS: dict[str, tuple[HiddenKind, Hide]] = {
    "crease": (_kind(
        "The sheet was folded: k0 + c exp(-((s/l - 0.6)/0.08)^2/2).",
        ("rest_curvature",), 10.0, 60.0, "1/m"), crease),
    "s_bend": (_kind(
        "The sheet dried in an S: k0 + c sin(2 pi s/l).",
        ("rest_curvature",), 4.0, 30.0, "1/m"), s_bend),
    "dry_patch": (_kind(
        "Between a quarter and a half of the length the sheet is dry: EIBM less by the share c.",
        ("eibm",), 0.3, 1.0, ""), dry_patch),
    "strained_gel": (_kind(
        "Bent gel moves more water: Me (1 + c tanh(k/(80/m))).",
        ("eibm", "compliance"), 0.25, 0.5, ""), strained_gel),
    "warm_electrodes": (_kind(
        "The current warms the outer electrode: a moment B c (s/l)^2 (V/2 V)^2.",
        ("even_moment", "eibm"), 6.0, 40.0, "1/m"), warm_electrodes),
    "droplet": (_kind(
        "A drop ties the sheet to the chamber: a force c along y at s = 0.45 l.",
        ("even_moment", "rest_curvature"), 0.3, 2.0, "mN"), droplet),
    "notch": (_kind(
        "The sheet is nicked: B (1 - c exp(-((s/l - 0.3)/0.07)^2/2)).",
        ("compliance",), 0.4, 0.9, ""), notch),
    "softens_when_driven": (_kind(
        "Ions soften the polymer under voltage: B (1 - c tanh(|V|/1 V)).",
        ("compliance",), 0.08, 0.5, ""), softens_when_driven),
    "one_sided": (_kind(
        "One face is stiffer when stretched: M + Me = B u (1 + c tanh(u/(5/m))).",
        ("compliance",), 0.1, 0.5, ""), one_sided),
    "arc_centre": (_kind(
        "The arc's centre lies beyond the clamp by c.",
        ("position",), 0.5, 4.0, "mm"), arc_centre),
    "uneven_screw": (_kind(
        "The stage's screw is uneven: p + c sin(2 pi p/12.5 mm).",
        ("position",), 0.4, 2.0, "mm"), uneven_screw),
    "push_and_pull": (_kind(
        "The load cell shows a push larger than a pull: F (1 + c) where F > 0.",
        ("load_cell",), 0.08, 0.5, ""), push_and_pull),
    "warm_hand": (_kind(
        "The load cell was touched before each run: F + c exp(-t/4 s).",
        ("load_cell", "time"), 0.15, 2.0, "mN"), warm_hand),
    "barrel": (_kind(
        "The lens bends the picture: r - m grows by 1 + c (|r - m|^2 - m^2)/(25 mm)^2.",
        ("camera",), 0.02, 0.2, ""), barrel),
    "lit_edge": (_kind(
        "Light from the side draws the curve to one face: c along its normal, from 4 mm on.",
        ("camera",), 0.2, 1.5, "mm"), lit_edge),
    "supply_beat": (_kind(
        "The supply comes and goes: Me (1 + c sin(6.6 pi t/session)).",
        ("time", "eibm"), 0.06, 0.4, ""), supply_beat),
    "remanence": (_kind(
        "Pulses leave a set: k0 + c (1 - exp(-pulses/6)), in each run anew.",
        ("time", "rest_curvature", "even_moment"), 1.5, 15.0, "1/m"), remanence),
}  # fmt: skip

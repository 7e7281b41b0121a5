"""What no catalogue knew when this world was made; a rolled camera has a name since."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._elements_beam import Cases, Law, Point
from benchmarks.worlds.generators._elements_known import since_slot_before
from benchmarks.worlds.session.effects import (
    Acting,
    Array,
    Image,
    Load,
    Sheet,
    acting,
)
from benchmarks.worlds.session.layout import Samples

PITCH_M = 12e-3
ROOM_S = 420.0


def _screw(cases: Cases, _at: Samples, _sheet: Sheet, size_mm: float) -> None:
    cases.position_m += size_mm * 1e-3 * np.sin(2.0 * np.pi * cases.position_m / PITCH_M)


def _setting(cases: Cases, at: Samples, _sheet: Sheet, size: float) -> None:
    cases.bow_per_m += size * np.sqrt(np.maximum(at.pulse + 1.0, 0.0) / 22.0)


def _one_sided(cases: Cases, at: Samples, _sheet: Sheet, lost: float) -> None:
    worn = np.where(at.sheet_V > 0.0, np.maximum(at.pulse, 0.0) / 22.0, 0.0)
    cases.moment_Nm *= 1.0 - lost * worn


def _squeezed(size: float) -> Law:
    def law(at: Point) -> None:
        near = np.exp(-(((at.s_m - at.contact_m) / 8e-3) ** 2))
        at.eibm_Nm = at.eibm_Nm * (1.0 - size * near)

    return law


def _crust(size: float) -> Law:
    def law(at: Point) -> None:
        at.stiffness_Nm2 = at.stiffness_Nm2 * (1.0 + size * np.exp(-at.s_m / 5e-3))

    return law


def _dip(size: float) -> Law:
    def law(at: Point) -> None:
        at.eibm_Nm = at.eibm_Nm * (1.0 - size * np.exp(-(((at.s_m - 20e-3) / 5e-3) ** 2)))

    return law


def _stretched_electrode(size: float) -> Law:
    def law(at: Point) -> None:
        at.eibm_Nm = at.eibm_Nm * np.exp(-size * (at.curvature_per_m / 40.0) ** 2)

    return law


def _rubs_farther(s_hat: Array, at: Samples, coefficient: float) -> Array:
    slid = since_slot_before(s_hat, at)
    return coefficient * (s_hat / 30e-3) ** 2 * slid / (np.abs(slid) + 0.05e-3)


def _bent(load: Load, size: float) -> Array:
    return load.force_N * (1.0 + size * load.force_N / 5e-3)


def _two_ranges(load: Load, size: float) -> Array:
    over = np.maximum(np.abs(load.force_N) - 1e-3, 0.0)
    return load.force_N + size * over * np.sign(load.force_N)


def _table(load: Load, size_mN: float) -> Array:
    return load.force_N - size_mN * 1e-3 * np.tanh(load.force_N / 0.3e-3)


def _room(load: Load, size_mN: float) -> Array:
    wave = np.sin(2.0 * np.pi * load.samples.session_s / ROOM_S)
    return load.force_N + size_mN * 1e-3 * wave


def _barrel(image: Image, size: float) -> tuple[Array, Array]:
    u, v = image.x_m - 25e-3, image.y_m - 15e-3
    at_clamp = np.hypot(25e-3, 15e-3) / 50e-3
    by = size * (np.hypot(u, v) / 50e-3) ** 2
    here = size * at_clamp**2
    return image.x_m - by * u - here * 25e-3, image.y_m - by * v - here * 15e-3


def _rolled(image: Image, angle: float) -> tuple[Array, Array]:
    c, s = np.cos(angle), np.sin(angle)
    return image.x_m * c - image.y_m * s, image.x_m * s + image.y_m * c


def _u(words: str, where: tuple[str, ...], **more: object) -> Acting:
    sizes, unit = more.pop("sizes"), more.pop("unit")
    return acting(words, None, where, sizes, unit, **more)  # type: ignore[arg-type]


FURTHER: dict[str, Acting] = {
    "screw_pitch": _u(
        "The stage's screw is uneven: p + c sin(2 pi p/12 mm).",
        ("position",), sizes=(0.3, 2.0), unit="mm", cases=_screw),
    "electrostatic_pull": _u(
        "The holder of the rolls attracts the sheet at either voltage: F + c (V/2 V)^2.",
        ("load_cell", "even_moment"), sizes=(0.08, 0.8), unit="mN",
        force=lambda at, c: at.force_N + c * 1e-3 * (at.samples.sheet_V / 2.0) ** 2),
    "permanent_set": _u(
        "Each pulse leaves something of its bend: k0 + c sqrt((k + 1)/22), k counts the pulses.",
        ("rest_curvature", "time", "even_moment"), sizes=(1.5, 15.0), unit="1/m", cases=_setting),
    "worn_anode": _u(
        "At positive voltage alone the EIBM goes down from pulse to pulse: 1 - c k/22.",
        ("time", "eibm", "even_moment"), sizes=(0.15, 0.8), unit="", cases=_one_sided),
    "squeezed_contact": _u(
        "The rolls squeeze out the water: Me (1 - c exp(-((s - s_hat)/8 mm)^2)).",
        ("eibm", "position"), sizes=(0.5, 1.0), unit="", law=_squeezed),
    "crust_at_clamp": _u(
        "The sheet has dried at the clamp: B (1 + c exp(-s/5 mm)).",
        ("compliance",), sizes=(0.5, 3.0), unit="", law=_crust),
    "electrode_dip": _u(
        "A scratch around 20 mm: Me (1 - c exp(-((s - 20 mm)/5 mm)^2)).",
        ("eibm",), sizes=(0.6, 1.0), unit="", law=_dip),
    "stretched_electrode": _u(
        "Where the sheet is bent its electrodes are torn: Me exp(-c (k/40 per m)^2).",
        ("eibm", "compliance"), sizes=(0.1, 0.4), unit="", law=_stretched_electrode),
    "bead": _u(
        "A drop of glue hangs at the visible end and pulls towards negative deflection.",
        ("even_moment",), sizes=(1e-4, 1e-3), unit="N", setting=lambda w: {"bead_N": w}),
    "second_range": _u(
        "Beyond 1 mN the amplifier of the load cell has another gain, by a share c.",
        ("load_cell",), sizes=(0.08, 0.6), unit="", force=_two_ranges),
    "bent_response": _u(
        "The load cell's response is bent: F (1 + c F/5 mN).",
        ("load_cell",), sizes=(0.08, 0.6), unit="", force=_bent),
    "dirty_stretch": _u(
        "Dirt towards the end rubs: c |N| (s/30 mm)^2 d/(|d| + 0.05 mm), d slid.",
        ("position",), sizes=(0.1, 0.6), unit="", slides=_rubs_farther),
    "rests_on_table": _u(
        "The sheet's edge rests on the table and takes c tanh(F/0.3 mN) of the force.",
        ("load_cell", "position"), sizes=(0.08, 0.8), unit="mN", force=_table),
    "room_temperature": _u(
        "The zero follows the air conditioning: c sin(2 pi t/420 s).",
        ("load_cell", "time"), sizes=(0.1, 1.0), unit="mN", force=_room),
    "barrel": _u(
        "The lens draws the picture together towards its middle: -c (rho/50 mm)^2 of rho.",
        ("camera",), sizes=(0.03, 0.3), unit="", image=_barrel),
    "rolled_camera": acting(
        "The camera is turned about its own axis: curves, not forces, are turned at the clamp.",
        "camera_roll", ("camera",), (0.015, 0.2), "rad", image=_rolled,
        parameters=lambda c: {"angle_rad": c}),
}  # fmt: skip

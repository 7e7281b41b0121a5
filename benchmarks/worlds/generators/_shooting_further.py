"""What no catalogue knew when this world was made; a bar that is drawn on has a name since."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._shooting_equilibrium import Lanes, Law, Section
from benchmarks.worlds.generators._shooting_specimen import step
from benchmarks.worlds.session.effects import (
    Acting,
    Array,
    Image,
    Load,
    Sheet,
    acting,
)
from benchmarks.worlds.session.layout import Samples

WIRES_M, CRACK_M = 10e-3, 28e-3
WRINKLED_PER_M = 35.0


def _under_voltage(lanes: Lanes, at: Samples, _sheet: Sheet, size: float) -> None:
    lanes.stiffness_Nm2 *= 1.0 + size * (at.sheet_V / 2.0) ** 2


def _warm(lanes: Lanes, at: Samples, _sheet: Sheet, size: float) -> None:
    period = float(np.max(at.phase_s))
    driven = np.where(at.pulse < 0.0, 0.0, at.pulse * period + at.phase_s)
    lanes.bow_per_m += size * (1.0 - np.exp(-driven / 5.0))


def _drying(lanes: Lanes, at: Samples, sheet: Sheet, _size: float) -> None:
    lanes.front_m += sheet.length_m * (1.0 - 0.6 * at.tau)


def _behind_the_front(size: float) -> Law:
    def law(here: Section) -> None:
        dry = step(here.s_m, here.lanes.front_m, 0.04 * here.length_m)
        here.stiffness_Nm2 = here.stiffness_Nm2 * (1.0 + size * dry)

    return law


def _by_curvature(size: float) -> Law:
    """Me = Me0 (1 - c k/40 per m), solved for k."""

    def law(here: Section) -> None:
        slope = size * here.eibm_Nm / 40.0
        here.eibm_Nm = here.eibm_Nm - slope * here.rest_per_m
        here.stiffness_Nm2 = here.stiffness_Nm2 + slope

    return law


def _wires(size: float) -> Law:
    """A straight spring beside the sheet: M + Me = B (k - k0) + c B k."""

    def law(here: Section) -> None:
        beside = 1.0 + size * (1.0 - step(here.s_m, WIRES_M, 0.7e-3))
        here.rest_per_m = here.rest_per_m / beside
        here.stiffness_Nm2 = here.stiffness_Nm2 * beside

    return law


def _wrinkles(size: float) -> Law:
    def law(here: Section) -> None:
        bent = np.abs(here.eibm_Nm + here.load_Nm) / here.stiffness_Nm2
        over = np.maximum(bent / WRINKLED_PER_M - 1.0, 0.0)
        here.stiffness_Nm2 = here.stiffness_Nm2 / (1.0 + size * over)

    return law


def _crack(size: float) -> Law:
    def law(here: Section) -> None:
        here.eibm_Nm = here.eibm_Nm * (1.0 - size * step(here.s_m, CRACK_M, 0.5e-3))

    return law


def _magnet(load: Load, size_mN: float) -> Array:
    near = 1.0 + ((np.nan_to_num(load.position_m, nan=1.0) - 14e-3) / 5e-3) ** 2
    return load.force_N + size_mN * 1e-3 / near


def _housing(load: Load, size_mN: float) -> Array:
    deep = np.maximum(np.nan_to_num(load.position_m, nan=0.0) - 18e-3, 0.0) / 10e-3
    return load.force_N + size_mN * 1e-3 * deep**2


def _halo(image: Image, size_mm: float) -> tuple[Array, Array]:
    ds = np.gradient(image.s_m, axis=1)
    curvature = np.gradient(image.phi_rad, axis=1) / np.where(ds > 0.0, ds, 1.0)
    aside = size_mm * 1e-3 * np.tanh(curvature / 40.0) * np.tanh(image.s_m / 3e-3)
    return (
        image.x_m - aside * np.sin(image.phi_rad),
        image.y_m + aside * np.cos(image.phi_rad),
    )


def _u(words: str, where: tuple[str, ...], **more: object) -> Acting:
    sizes, unit = more.pop("sizes"), more.pop("unit")
    return acting(words, None, where, sizes, unit, **more)  # type: ignore[arg-type]


FURTHER: dict[str, Acting] = {
    "stiffness_under_voltage": _u(
        "The sheet is stiffer while a voltage is across it: B (1 + c (V/2 V)^2).",
        ("compliance", "eibm"), sizes=(0.1, 0.8), unit="", cases=_under_voltage),
    "thermal_bow": _u(
        "The current's heat bows the sheet: k0 + c (1 - exp(-t/5 s)), t under voltage.",
        ("even_moment", "rest_curvature", "time"), sizes=(1.5, 15.0), unit="1/m", cases=_warm),
    "drying_front": _u(
        "A front moves from the tip over 60 % of the sheet in the session; behind it B (1 + c).",
        ("time", "compliance"), sizes=(0.25, 2.0), unit="", cases=_drying,
        law=_behind_the_front),
    "eibm_by_curvature": _u(
        "Where the sheet is bent its electrodes conduct less: Me (1 - c k/40 per m).",
        ("eibm", "compliance"), sizes=(0.1, 0.4), unit="", law=_by_curvature),
    "wire_spring": _u(
        "Wires along the first 10 mm bend as a straight spring, c times as stiff as the sheet.",
        ("compliance", "rest_curvature"), sizes=(0.15, 1.5), unit="", law=_wires),
    "wrinkles": _u(
        "From a change of curvature of 35 per m on it wrinkles: B/(1 + c (u/35 per m - 1)).",
        ("compliance", "eibm"), sizes=(0.3, 0.6), unit="", law=_wrinkles),
    "cracked_electrode": _u(
        "A crack of the electrode 28 mm from the clamp takes a share c of the EIBM beyond it.",
        ("eibm",), sizes=(0.4, 1.0), unit="", law=_crack),
    "crosstalk": _u(
        "The voltage leaks into the load cell's wires: F + c V/2 V.",
        ("load_cell",), sizes=(0.06, 0.8), unit="mN",
        force=lambda at, c: at.force_N + c * 1e-3 * at.samples.sheet_V / 2.0),
    "magnet": _u(
        "A magnet of the stage pulls the load cell: F + c/(1 + ((p - 14 mm)/5 mm)^2).",
        ("load_cell", "position"), sizes=(0.15, 1.5), unit="mN", force=_magnet),
    "touching_housing": _u(
        "From 18 mm on the sheet's end presses on the housing: F + c ((p - 18 mm)/10 mm)^2.",
        ("load_cell", "position"), sizes=(0.15, 1.5), unit="mN", force=_housing),
    "bent_force": _u(
        "The load cell's response is bent: F + c (F/3 mN)^2.",
        ("load_cell",), sizes=(0.1, 1.0), unit="mN",
        force=lambda at, c: at.force_N + c * 1e-3 * (at.force_N / 3e-3) ** 2),
    "rocking_rolls": _u(
        "The pair of rolls rocks on a spring and turns the sheet towards the radius: -c gamma.",
        ("position", "compliance"), sizes=(1e-6, 1.5e-5), unit="N m/rad",
        setting=lambda c: {"rocking_Nm_per_rad": c}),
    "stage_backlash": _u(
        "The stage has play, which the force takes up: p + c tanh(F/0.4 mN).",
        ("position", "load_cell"), sizes=(0.15, 1.5), unit="mm",
        setting=lambda c: {"backlash_m": c * 1e-3}),
    "halo": _u(
        "Glare at the concave side draws the curve aside: c tanh(k/40 per m) along the normal.",
        ("camera",), sizes=(0.08, 1.0), unit="mm", image=_halo),
    "bar_drawn_on": acting(
        "The elongation bends, thinner towards its end, from c/2 of the sheet's compliance on; the"
        " picture is drawn straight on from the sheet's end.",
        "elongation_flexibility", ("compliance",), (0.02, 0.4), "",
        setting=lambda c: {"bar_compliance": c, "bar_drawn_on": True}),
}  # fmt: skip

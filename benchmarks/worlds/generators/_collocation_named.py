"""What the catalogue has a name for, as this laboratory would write it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.generators._collocation_bvp import A
from benchmarks.worlds.generators._collocation_plant import Load, Plant, Stay, lagged

Spoil = Callable[[Plant, float], None]
MILLI = 1e-3
FAR_M = 0.0195  # from here on the rolls hold the strip


def wedge(plant: Plant, c: float) -> None:
    """Put a wedge into the clamp."""
    for strip in plant.strips.values():
        strip.clamp_rad += c


def curlier(plant: Plant, c: float) -> None:
    """Multiply the rest curvature."""
    for strip in plant.strips.values():
        rest = tuple(strip.k0)
        strip.k0.append(lambda s, rest=rest: c * sum(f(s) for f in rest))


def contact_resistance(plant: Plant, c: float) -> None:
    """Let the EIBM fall hyperbolically from the clamp."""
    for strip in plant.strips.values():
        free = strip.free_m
        strip.eibm.append(lambda s, _a, free=free: c / np.log1p(c) / (1.0 + c * s / free))


def unlike_faces(plant: Plant, c: float) -> None:
    """Add a moment that has the same sign at both voltages, and fades along the strip."""
    for strip in plant.strips.values():
        free, size = strip.free_m, strip.bends_per_m[0]
        strip.even.append(lambda s, free=free, size=size: c * size * 2.0 * (1.0 - s / free))


def leaning(plant: Plant, c: float) -> None:
    """Hang a uniform weight on strip and bar."""
    for strip in plant.strips.values():
        whole = strip.free_m + strip.bar_m
        strip.hangs.append(lambda s, whole=whole: -c * (whole - s))


def sprung_clamp(plant: Plant, c: float) -> None:
    """Hold the strip by a spring."""
    for strip in plant.strips.values():
        strip.clamp_gives = c


def glued_joint(plant: Plant, c: float) -> None:
    """Let the bar turn in its joint."""
    for strip in plant.strips.values():
        strip.joint = c


def yielding_gel(plant: Plant, c: float) -> None:
    """Let the curvature grow faster than the moment."""
    for strip in plant.strips.values():
        strip.material = lambda u: u * (1.0 + c * (1.0 - 1.0 / np.sqrt(1.0 + (u / 30.0) ** 2)))


def taper(plant: Plant, c: float) -> None:
    """Let the thickness grow along the strip."""
    for strip in plant.strips.values():
        free = strip.free_m
        strip.compliance.append(lambda s, free=free: (1.0 + c * (s / free - 0.5)) ** -3)


def pitch(plant: Plant, c: float) -> None:
    """Make the rack's pitch wrong."""
    plant.stage.append(lambda p: p * (1.0 + c))


def dragging_rolls(plant: Plant, c: float) -> None:
    """Rub with a force that does not depend on the load."""
    plant.drag_N = c * MILLI


def thick_strip(plant: Plant, c: float) -> None:
    """Touch the strip on the side that presses."""
    for strip in plant.strips.values():
        strip.beside_m = c * MILLI


def stick_slip(plant: Plant, c: float) -> None:
    """Hold the force until it has changed by more than c, then let it go."""

    def held(stay: Stay, load: Load) -> A:
        if stay.stated_m is None or stay.stated_m < FAR_M:
            return load.shown_N
        out, here = np.empty_like(load.shown_N), float(load.shown_N[0])
        for i, force in enumerate(load.shown_N.tolist()):
            here = force if abs(force - here) > c * MILLI else here
            out[i] = here
        return out

    plant.cell.append(held)


def warm_room(plant: Plant, c: float) -> None:
    """Let the zero rise with the temperature of the room."""
    plant.cell.append(
        lambda stay, load: load.shown_N + c * MILLI * np.sin(0.5 * np.pi * stay.share)
    )


def zero(plant: Plant, c: float) -> None:
    """Shift the zero."""
    plant.cell.append(lambda _stay, load: load.shown_N + c * MILLI)


def stiffening_arm(plant: Plant, c: float) -> None:
    """Let the load cell's arm give way, ever less."""
    for strip in plant.strips.values():
        strip.yields = lambda force: c * force / (1.0 + np.abs(force) / 8e-3)


def lazy_gauge(plant: Plant, c: float) -> None:
    """Lag behind the load by c, some way after each turn of it."""

    def lags(_stay: Stay, load: Load) -> A:
        out = load.shown_N.copy()
        turned = before = float(out[0])
        way = 0.0
        for i, force in enumerate(load.shown_N.tolist()):
            if (force - before) * way < 0.0:
                turned = before
            way = np.sign(force - before) if abs(force - before) > 1e-9 else way
            out[i] -= c * MILLI * np.tanh((force - turned) / 4e-4)
            before = force
        return out

    plant.cell.append(lags)


def crosstalk(plant: Plant, c: float) -> None:
    """Feel a share of the force along the radius."""
    plant.cell.append(lambda _stay, load: load.shown_N - np.tan(c) * load.outwards_N)


def drying_meniscus(plant: Plant, c: float) -> None:
    """Pull along the normal, less and less since the moistening."""

    def pulled(stay: Stay, load: Load) -> A:
        left = np.maximum(1.0 - (stay.moist_s + stay.t) / 90.0, 0.0)
        return np.asarray(load.shown_N + c * MILLI * left * np.cos(load.gamma_rad))

    plant.cell.append(pulled)


def tilted_camera(plant: Plant, c: float) -> None:
    """Project a plane that comes nearer towards positive deflection."""
    plant.lens.append(lambda x, y: (x / (1.0 - c * y / 0.05), y / (1.0 - c * y / 0.05)))


def tall_pixels(plant: Plant, c: float) -> None:
    """Stretch the picture along y."""
    plant.lens.append(lambda x, y: (x, y * (1.0 + c)))


def water_returns(plant: Plant, c: float) -> None:
    """Take a growing share of the EIBM away within each pulse; settled is what is sampled."""

    def left(age_s: A | float) -> A:
        return np.asarray(1.0 - c * (1.0 - np.exp(-np.asarray(age_s) / 0.9)))

    plant.response.append(lambda stay, a: a * left(stay.age_s) / left(stay.sample_s))


def slow_capacitor(plant: Plant, c: float) -> None:
    """Charge through a resistance."""
    plant.response.append(lambda _stay, a: lagged(a, c))


def thirst(plant: Plant, c: float) -> None:
    """Let the EIBM grow with the time under voltage since the moistening."""
    plant.response.append(lambda stay, a: a * (1.0 + c * (stay.worked - 0.5)))


def settling_water(plant: Plant, c: float) -> None:
    """Weaken the first four pulses, evenly less."""
    plant.response.append(
        lambda stay, a: a * (1.0 - c * np.clip(1.0 - np.maximum(stay.count, 0.0) / 4.0, 0.0, 1.0))
    )


def hardening_skin(plant: Plant, c: float) -> None:
    """Stiffen the strip as it dries under voltage, until it is dry."""
    plant.stiffness.append(lambda stay, _a: 1.0 + c * (0.57 - np.exp(-2.0 * stay.worked)))


def standard_solid(plant: Plant, c: float) -> None:
    """Relax with one time constant in each run."""
    late = np.exp(-5.0 / 6.0)
    plant.stiffness.append(lambda stay, _a: 1.0 + c * (np.exp(-stay.t / 6.0) - late))


def _kind(
    words: str, known_as: str, location: str, typical: float, largest: float, unit: str = "",
    needs: tuple[str, ...] = (), own_form: bool = False,
) -> HiddenKind:  # fmt: skip
    return HiddenKind(
        words=words, known_as=known_as, locations=(location,), typical=typical, largest=largest,
        unit=unit, needs=needs, own_form=own_form,
    )  # fmt: skip


NAMED: dict[str, tuple[HiddenKind, Spoil]] = {
    "wedge": (_kind(
        "The clamp holds the sheet at an angle: theta(0) = c.",
        "clamp_angle", "rest_curvature", 0.02, 0.2, "rad", own_form=True), wedge),
    "curlier": (_kind(
        "The sheet curls more at rest: (1 + c) k0.",
        "initial_curvature", "rest_curvature", 0.06, 0.6), curlier),
    "contact_resistance": (_kind(
        "EIBM falls from the contacts as 1/(1 + c s/l), about its mean.",
        "nonuniform_eibm", "eibm", 1.0, 10.0), contact_resistance),
    "unlike_faces": (_kind(
        "One face swells more: a moment of 2 c Me(+2 V) (1 - s/l) (V/2 V)^2 at either voltage.",
        "eibm_asymmetry", "even_moment", 0.08, 0.5), unlike_faces),
    "leaning": (_kind(
        "The rig leans: a weight of c acts along -y on sheet and elongation alike.",
        "gravity", "even_moment", 0.003, 0.03, "N/m", own_form=True), leaning),
    "sprung_clamp": (_kind(
        "The clamp turns as a spring: theta(0) = c M(0).",
        "clamp_compliance", "compliance", 60.0, 600.0, "rad/(N m)", own_form=True), sprung_clamp),
    "glued_joint": (_kind(
        "The glue between sheet and elongation turns by c l M(l)/B.",
        "elongation_flexibility", "compliance", 0.1, 1.0), glued_joint),
    "yielding_gel": (_kind(
        "The sheet softens: u = m (1 + c (1 - 1/sqrt(1 + (m/(30/m))^2))), m = (M + Me)/B.",
        "nonlinear_stiffness", "compliance", 0.15, 0.5), yielding_gel),
    "taper": (_kind(
        "The sheet is thicker at one end: B (1 + c (s/l - 1/2))^3.",
        "nonuniform_stiffness", "compliance", 0.1, 0.8), taper),
    "pitch": (_kind(
        "The rack's pitch is wrong: (1 + c) p.",
        "position_error", "position", 0.03, 0.2), pitch),
    "dragging_rolls": (_kind(
        "Squeezed between the rolls the sheet feels c along itself, against its last sliding.",
        "roll_friction", "position", 0.15, 1.0, "mN"), dragging_rolls),
    "thick_strip": (_kind(
        "The rolls press on the sheet's face: c N/sqrt(N^2 + (0.1 mN)^2) beside its middle.",
        "roll_offset", "position", 0.3, 3.0, "mm"), thick_strip),
    "stick_slip": (_kind(
        "From 19.5 mm on the sheet sticks until the force has changed by c, then slips.",
        "roll_sticking", "position", 0.6, 3.0, "mN"), stick_slip),
    "warm_room": (_kind(
        "The room warms up: F + c sin(pi t/(2 sessions)).",
        "force_drift", "load_cell", 0.1, 2.0, "mN"), warm_room),
    "zero": (_kind(
        "The load cell's zero is off: F + c.",
        "force_offset", "load_cell", 0.1, 2.0, "mN", own_form=True), zero),
    "stiffening_arm": (_kind(
        "The load cell's arm bends: p + c F/(1 + |F|/8 mN).",
        "load_cell_compliance", "load_cell", 0.15, 2.0, "mm/mN"), stiffening_arm),
    "lazy_gauge": (_kind(
        "The gauge's glue creeps: F - c tanh(change since the load last turned/0.4 mN).",
        "load_cell_hysteresis", "load_cell", 0.08, 1.0, "mN"), lazy_gauge),
    "crosstalk": (_kind(
        "The load cell stands askew: F + N sin gamma tan c.",
        "load_cell_misalignment", "load_cell", 0.1, 0.7, "rad"), crosstalk),
    "drying_meniscus": (_kind(
        "A meniscus pulls along the normal: F + c cos gamma (1 - t/90 s), t since the moistening.",
        "surface_tension", "load_cell", 0.15, 1.5, "mN"), drying_meniscus),
    "tilted_camera": (_kind(
        "The camera is tilted about the clamp's axis: r seen = r/(1 - c y/50 mm).",
        "camera_perspective", "camera", 0.015, 0.2), tilted_camera),
    "tall_pixels": (_kind(
        "The pixels are not square: y seen = (1 + c) y.",
        "camera_scale", "camera", 0.012, 0.2), tall_pixels),
    "water_returns": (_kind(
        "Water flows back: EIBM is 1 - c (1 - exp(-t/0.9 s)), over its value when sampled.",
        "back_relaxation", "time", 0.1, 0.5, needs=("series",)), water_returns),
    "slow_capacitor": (_kind(
        "The sheet charges through a resistance: EIBM follows the voltage with the time c.",
        "charging_lag", "time", 0.1, 0.6, "s", needs=("series",), own_form=True), slow_capacitor),
    "thirst": (_kind(
        "EIBM grows with the time under voltage since the moistening: 1 + c (t/13.2 s - 1/2).",
        "eibm_drift", "time", 0.1, 1.0), thirst),
    "settling_water": (_kind(
        "EIBM of the first four pulses k of a run is less: 1 - c (1 - k/4).",
        "first_pulse_transient", "time", 0.2, 0.9), settling_water),
    "hardening_skin": (_kind(
        "The sheet dries under voltage: B (1 + c (0.57 - exp(-2 t/13.2 s))).",
        "stiffness_drift", "time", 0.1, 0.8), hardening_skin),
    "standard_solid": (_kind(
        "A standard linear solid: B (1 + c (exp(-t/6 s) - exp(-5/6))), t in the run.",
        "viscoelastic_creep", "time", 0.05, 0.5), standard_solid),
}  # fmt: skip

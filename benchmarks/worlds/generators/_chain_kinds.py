"""What the world `chain` can hide, in its own words and formulas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.generators._chain_links import Bending, Floats
from benchmarks.worlds.generators._chain_plant import LONG, SHORT, Course, Load, Plant, Sheet, lag

SAMPLE_S = 0.5
Change = Callable[[Plant, float], None]
Parameters = Callable[[float], Mapping[str, float]]


@dataclass(frozen=True)
class Kind:
    """A kind with what it changes and, in the catalogue's form, the catalogue's parameters."""

    told: HiddenKind
    change: Change
    parameters: Parameters | None = None


def _kind(
    words: str, known_as: str | None, where: str, sizes: tuple[float, float, str], change: Change,
    parameters: Parameters | None = None, needs: str = "",
) -> Kind:  # fmt: skip
    typical, largest, unit = sizes
    told = HiddenKind(
        words=words, known_as=known_as, locations=tuple(where.split()), typical=typical,
        largest=largest, unit=unit, needs=tuple(needs.split()), own_form=parameters is not None,
    )  # fmt: skip
    return Kind(told, change, parameters)


# ------------------------------------------------------------------------------ along the sheet


def _bump(at_m: float, width_m: float, s: Floats) -> Floats:
    return np.asarray(np.exp(-0.5 * ((s - at_m) / width_m) ** 2))


def _starved(plant: Plant, size: float) -> None:
    plant.profile.append(lambda _, s: 1.0 / (1.0 + size * s / 0.05))


def _patch(plant: Plant, size: float) -> None:
    plant.profile.append(lambda sheet, s: 1.0 + size * _only(sheet, LONG) * _bump(0.022, 3e-3, s))


def _only(sheet: Sheet, name: str) -> float:
    return 1.0 if sheet.name == name else 0.0


def _more_curved(plant: Plant, size: float) -> None:
    plant.rest.append(lambda _, s: np.full(len(s), size))


def _kinked(plant: Plant, size: float) -> None:
    plant.rest.append(lambda sheet, s: size * _only(sheet, LONG) * _bump(0.03, 1.5e-3, s))


def _graded(plant: Plant, size: float) -> None:
    plant.softness.append(lambda sheet, s: (1 + size / 2) / (1 + size * s / sheet.free_m))


def _creased(plant: Plant, size: float) -> None:
    plant.softness.append(lambda sheet, s: 1.0 + size * _only(sheet, LONG) * _bump(0.018, 1e-3, s))


def _squeezed(plant: Plant, size: float) -> None:
    plant.even.append(lambda _, s: size * np.exp(-s / 6e-3))


def _stiffening(plant: Plant, size: float) -> None:
    plant.bending = _softer(size)


def _softer(size: float) -> Bending:
    """Return u of v = moment over B, for a strip that stiffens by `size` at 10 per m."""
    return lambda v: v / (1.0 + 4.0 * size * (v / 10.0) ** 2) ** 0.25


def _one_sided(plant: Plant, size: float) -> None:
    """The face that is pulled where the strip bends towards +y gives way less than the other."""
    plant.bending = lambda v: np.asarray(v / (1.0 + 0.5 * size * (1.0 + np.tanh(v / 6.0))))


# --------------------------------------------------------------------------------------- in time


def _drying(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: np.exp(size * (c.session - 0.5)))


def _wearing(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 + size * (c.session - 0.5)))


def _wearing_late(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 + size * (c.session**3 - 0.25)))


def _yielding(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: ((c.time_s + 0.3) / 5.0) ** -size)


def _slow(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda _, u: lag(u, size))


def _relaxing(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 - size * -np.expm1(-((c.since_s / 0.6) ** 0.7))))


def _waking(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 - size / (1.0 + np.maximum(c.pulse, 0.0)) ** 1.5))


def _ringing(plant: Plant, size: float) -> None:
    def rung(c: Course, u: Floats) -> Floats:
        wave = np.exp(-c.since_s / 0.25) * np.sin(2 * np.pi * c.since_s / 0.17)
        return np.asarray(u * (1.0 + size * wave))

    plant.amplitude.append(rung)


def _cracking(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * np.where(c.session > 0.62, 1.0 - size, 1.0))


def _breathing(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 + size * np.sin(5 * np.pi * c.session)))


def _stuttering(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 + size * np.where(c.pulse % 4 < 2, 0.5, -0.5)))


def _charged_stiff(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: 1.0 + size * np.abs(c.risen()))


def _stiff_anode(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: 1.0 + size * np.maximum(c.risen(), 0.0))


def _wetter_outwards(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: 1.0 - size * ((c.position_m or 0.0) / 0.03) ** 0.7)


# ---------------------------------------------------------------------- clamp, rolls, load cell


def _set(name: str, scale: float = 1.0) -> Change:
    return lambda plant, size: setattr(plant, name, size * scale)


def _moved(plant: Plant, size: float) -> None:
    plant.place.append(lambda p, _: p + size * 1e-3)


def _screw(plant: Plant, size: float) -> None:
    plant.place.append(lambda p, _: p + size * 1e-3 * float(np.sin(2 * np.pi * p / 0.014)))


def _backlash(plant: Plant, size: float) -> None:
    plant.place.append(lambda p, _: p + size * 0.5e-3 * (-1.0) ** round(p / 0.005))


def _knocked(plant: Plant, size: float) -> None:
    plant.place.append(lambda p, share: p + size * 1e-3 * (0.2 < share < 0.45))


def _felt(more_mN: Callable[[Course, Load, float], Floats]) -> Change:
    """Return a change that adds a force in mN to what the cell shows."""

    def change(plant: Plant, size: float) -> None:
        plant.felt.append(lambda c, load: 1e-3 * more_mN(c, load, size))

    return change


def _behind(c: Course, load: Load, size: float) -> Floats:
    """Return what a play of half width `size` in mN takes from the force."""
    force, shown = 1e3 * load.force_N, np.empty(len(load.force_N))
    if c.position_m is None:
        return np.zeros(len(shown))
    at = force[0]
    for i, one in enumerate(force.tolist()):
        at = max(one - size, min(one + size, at))
        shown[i] = at
    return np.asarray(shown - force)


def _stuck(c: Course, load: Load, size: float) -> Floats:
    far = c.position_m is not None and c.position_m > 0.0199
    return -size * np.tanh(1e3 * load.force_N / 0.02) * far


def _jerked(c: Course, load: Load, size: float) -> Floats:
    """Return what rolls hold back that let go of 3/5 of it once it has grown to `size` in mN."""
    far = c.position_m is not None and c.position_m > 0.0149
    change = 1e3 * (load.force_N - load.force_N[0])
    grown = np.abs(change) / max(abs(size), 1e-9)
    kept = np.where(grown < 1.0, grown, 0.4 + np.mod(grown - 1.0, 0.6))
    return np.asarray(-size * np.sign(change) * kept * far)


def _dragged(c: Course, load: Load, size: float) -> Floats:
    way = np.where(c.volts < 0.0, -1.0, 1.0)
    return np.asarray(-size * way * np.sin(load.lean_rad))


def _wet(c: Course, load: Load, size: float) -> Floats:
    return size * np.cos(load.lean_rad) * _only(c.sheet, SHORT)


def _drying_rolls(c: Course, load: Load, size: float) -> Floats:
    return size * np.cos(load.lean_rad) * (1.0 - 0.5 * c.session)


def _turned(_: Course, load: Load, size: float) -> Floats:
    felt = load.normal_N * np.cos(load.lean_rad - size)
    return np.asarray(1e3 * (felt - load.force_N))


def _cubic(_: Course, load: Load, size: float) -> Floats:
    return np.asarray(size * (1e3 * load.force_N) ** 2 * np.sign(load.force_N))


def _cable(c: Course, _: Load, size: float) -> Floats:
    p = c.position_m or 0.0
    return np.full(len(c.time_s), size * np.cos(2 * np.pi * p / 0.02))


def _swinging(c: Course, _: Load, size: float) -> Floats:
    return np.asarray(size * np.sin(5 * np.pi * c.session))


# ------------------------------------------------------------------------------------ the camera


def _larger(plant: Plant, size: float) -> None:
    plant.seen.append(lambda _, xy: (1.0 + size) * xy)


def _tilted(plant: Plant, size: float) -> None:
    plant.seen.append(lambda _, xy: xy / (1.0 - size * xy[..., :1] / 0.05))


def _barrel(plant: Plant, size: float) -> None:
    """The lens's axis is 25 mm from the clamp."""
    centre = np.array([0.025, 0.0])

    def pictured(_: Course, xy: Floats) -> Floats:
        away = xy - centre
        return centre + away * (1.0 + size * np.sum(away**2, axis=-1, keepdims=True) / 0.025**2)

    plant.seen.append(pictured)


def _outer_face(plant: Plant, size: float) -> None:
    def pictured(_: Course, xy: Floats) -> Floats:
        along = np.gradient(xy, axis=-2)
        along /= np.linalg.norm(along, axis=-1, keepdims=True)
        bright = np.sign(xy[..., -1:, 1:])  # the face that is stretched
        return xy + 1e-3 * size * bright * np.stack([-along[..., 1], along[..., 0]], axis=-1)

    plant.seen.append(pictured)


def _sinking(plant: Plant, size: float) -> None:
    def pictured(c: Course, xy: Floats) -> Floats:
        return xy + np.array([0.0, 1e-3 * size * float(c.session[0])])

    plant.seen.append(pictured)


# ------------------------------------------------------------------------------------- the table

KINDS: dict[str, Kind] = {
    # what the catalogue has
    "starved_electrode": _kind(
        "The electrodes starve: EIBM as 1/(1 + c s/50 mm).", "nonuniform_eibm", "eibm",
        (0.5, 30.0, "-"), _starved),
    "curled": _kind(
        "The sheet at rest is more curved than stated by c, everywhere.", "initial_curvature",
        "rest_curvature", (1.0, 12.0, "1/m"), _more_curved, lambda c: {"curvature_error_per_m": c}),
    "graded": _kind(
        "Stiffness grows as 1 + c s/l.", "nonuniform_stiffness", "compliance", (0.2, 5.0, "-"),
        _graded, lambda c: {"relative_change": c}),
    "stiffening": _kind(
        "Bending u = v/(1 + 4 c (v/10 per m)^2)^(1/4), v the moment over B.", "nonlinear_stiffness",
        "compliance", (0.02, 0.3, "-"), _stiffening),
    "drying": _kind(
        "Stiffness goes as exp(c (tau - 1/2)) over the session.", "stiffness_drift", "time",
        (0.1, 0.7, "-"), _drying),
    "wearing": _kind(
        "EIBM goes as 1 + c (tau - 1/2) over the session.", "eibm_drift", "time", (0.1, 1.4, "-"),
        _wearing, lambda c: {"relative_change": c}),
    "wearing_late": _kind(
        "The EIBM goes as 1 + c (tau^3 - 1/4) over the session.", "eibm_drift", "time",
        (0.1, 1.3, "-"), _wearing_late),
    "yielding": _kind(
        "Stiffness goes as ((t + 0.3 s)/5 s)^-c in each run.", "viscoelastic_creep", "time",
        (0.02, 0.4, "-"), _yielding),
    "slow_charge": _kind(
        "EIBM follows the voltage's rise by a first-order lag of c.", "charging_lag", "time",
        (0.08, 1.0, "s"), _slow, lambda c: {"time_constant_s": c}, needs="series"),
    "relaxing": _kind(
        "Of the EIBM c (1 - exp(-(t/0.6 s)^0.7)) is lost in each pulse.", "back_relaxation", "time",
        (0.1, 0.8, "-"), _relaxing, needs="series"),
    "waking": _kind(
        "Pulse k has the EIBM 1 - c/(1 + k)^1.5 of the settled one.", "first_pulse_transient",
        "time", (0.2, 1.0, "-"), _waking, needs="series"),
    "heavy": _kind(
        "The rig leans, and a weight c per length acts along -y.", "gravity", "even_moment",
        (0.003, 0.1, "N/m"), _set("weight_N_per_m"), lambda c: {"load_N_per_m": c}),
    "meniscus": _kind(
        "Water pulls the short sheet's roll by c along the normal.", "surface_tension",
        "load_cell", (0.1, 3.0, "mN"), _felt(_wet), lambda c: {"force_mN": c}),
    "drying_rolls": _kind(
        "Water pulls either sheet's roll by c (1 - tau/2) along the normal.", "surface_tension",
        "load_cell", (0.1, 3.0, "mN"), _felt(_drying_rolls)),
    "loose_clamp": _kind(
        "The clamp turns by c times the load's moment.", "clamp_compliance", "compliance",
        (30.0, 5e3, "rad/(N m)"), _set("clamp_give_rad_per_Nm"),
        lambda c: {"rotation_rad_per_Nm": c}),
    "crooked_clamp": _kind(
        "The sheet leaves the clamp at an angle c.", "clamp_angle",
        "rest_curvature position camera", (0.01, 0.2, "rad"), _set("clamp_angle_rad"),
        lambda c: {"angle_rad": c}),
    "rubbing": _kind(
        "The rolls drag along the sheet with c |N|, each polarity against the other's way.",
        "roll_friction", "position load_cell", (0.1, 0.8, "-"), _set("friction")),
    "thick_rolls": _kind(
        "The sheet passes the arc's point at a distance c along its normal.", "roll_offset",
        "position", (0.3, 3.0, "mm"), _set("beside_m", 1e-3), lambda c: {"offset_mm": c}),
    "sticking": _kind(
        "From 20 mm on the rolls hold back c of the force.", "roll_sticking", "position load_cell",
        (0.1, 2.0, "mN"), _felt(_stuck)),
    "jerking": _kind(
        "From 15 mm on the rolls hold back a change of the force, and let go by 3 c/5 at c each.",
        "roll_sticking", "position load_cell", (0.1, 2.0, "mN"), _felt(_jerked)),
    "tight_bearings": _kind(
        "The rolls' bearings drag along the sheet with c, outwards but at the negative polarity.",
        "roll_friction", "position load_cell", (0.05, 3.0, "mN"), _felt(_dragged)),
    "zero": _kind(
        "The cell's zero is c.", "force_offset", "load_cell", (0.05, 5.0, "mN"),
        _felt(lambda c, _, size: np.full(len(c.time_s), size)), lambda c: {"force_mN": c}),
    "warming_cell": _kind(
        "The cell's zero rises as c sqrt(tau) over the session.", "force_drift", "load_cell",
        (0.15, 5.0, "mN"), _felt(lambda c, _, size: size * np.sqrt(c.session))),
    "askew_cell": _kind(
        "The cell's axis is turned by c: it shows N cos(gamma - c).", "load_cell_misalignment",
        "load_cell", (0.06, 0.6, "rad"), _felt(_turned), lambda c: {"angle_rad": c}),
    "play": _kind(
        "The cell follows its load with a play of c to either side.", "load_cell_hysteresis",
        "load_cell", (0.05, 1.0, "mN"), _felt(_behind), lambda c: {"force_mN": c}),
    "soft_cell": _kind(
        "The cell gives way along the arc by c times the force.", "load_cell_compliance",
        "load_cell position", (0.2, 3.0, "mm/mN"), _set("cell_give_m_per_N"),
        lambda c: {"compliance_mm_per_mN": c}),
    "wrong_place": _kind(
        "The cell stands c farther along the arc than stated.", "position_error", "position",
        (0.3, 6.0, "mm"), _moved, lambda c: {"offset_mm": c}),
    "wrong_scale": _kind(
        "Lengths in the picture are 1 + c of the true ones.", "camera_scale", "camera",
        (0.005, 0.3, "-"), _larger, lambda c: {"relative_error": c}),
    "tilted_camera": _kind(
        "The picture is r/(1 - c x/50 mm).", "camera_perspective", "camera", (0.005, 0.3, "-"),
        _tilted),
    "late_picture": _kind(
        "A picture is c older than its reading.", "frame_delay", "camera time", (0.25, 0.49, "s"),
        _set("late_s"), lambda c: {"delay_s": c}),
    # what no catalogue has
    "strong_patch": _kind(
        "A patch at 22 mm, 6 mm wide, has 1 + c of the EIBM.", None, "eibm", (0.3, 8.0, "-"),
        _patch),
    "kink": _kind(
        "The long sheet has a kink: c more curved within 3 mm at 30 mm.", None, "rest_curvature",
        (5.0, 60.0, "1/m"), _kinked),
    "crease": _kind(
        "The long sheet is creased at 18 mm: there its compliance is 1 + c.", None, "compliance",
        (1.0, 30.0, "-"), _creased),
    "squeezed_root": _kind(
        "A moment that goes with V^2 and falls as exp(-s/6 mm): c at 2 V.", None,
        "even_moment eibm", (2.0, 60.0, "1/m"), _squeezed),
    "ringing": _kind(
        "After each edge the EIBM rings: 1 + c exp(-t/0.25 s) sin(2 pi t/0.17 s).", None, "time",
        (0.1, 1.0, "-"), _ringing, needs="series"),
    "crack": _kind(
        "After 62 % of the session the electrode cracks: c of the EIBM is lost at once.", None,
        "time", (0.05, 0.6, "-"), _cracking),
    "stutter": _kind(
        "Two pulses stronger, two weaker, by c from one to the other.", None, "time",
        (0.03, 0.6, "-"), _stuttering, needs="series"),
    "charged_stiff": _kind(
        "The sheet is stiffer by c under 2 V, whatever the sign.", None, "compliance eibm",
        (0.1, 1.0, "-"), _charged_stiff),
    "stiff_anode": _kind(
        "The sheet is stiffer by c under +2 V, and not under -2 V.", None, "compliance eibm",
        (0.1, 1.5, "-"), _stiff_anode),
    "one_sided": _kind(
        "Bending u = v/(1 + c (1 + tanh(v/6 per m))/2), v the moment over B: stiffer one way.",
        None, "compliance", (0.1, 1.5, "-"), _one_sided),
    "wetter_outwards": _kind(
        "Wet rolls soften more of the sheet the farther out they stand: B (1 - c (p/30 mm)^0.7).",
        None, "compliance position", (0.05, 0.7, "-"), _wetter_outwards),
    "lead_screw": _kind(
        "The stage's screw errs by c sin(2 pi p/14 mm).", None, "position", (0.2, 4.0, "mm"),
        _screw),
    "bent_scale": _kind(
        "The cell shows F + c F |F|, F in mN.", None, "load_cell", (0.02, 0.3, "1/mN"),
        _felt(_cubic)),
    "cable": _kind(
        "The cell's cable pulls by c cos(2 pi p/20 mm).", None, "load_cell position",
        (0.1, 3.0, "mN"), _felt(_cable)),
    "backlash": _kind(
        "The stage has backlash: every second position is c farther than the others.", None,
        "position", (0.3, 4.0, "mm"), _backlash),
    "knocked_stage": _kind(
        "Somebody knocks the stage: from 20 to 45 % of the session it stands c farther.", None,
        "position time", (0.3, 4.0, "mm"), _knocked),
    "breathing": _kind(
        "The EIBM swings by c sin(5 pi tau) over the session.", None, "time", (0.05, 0.6, "-"),
        _breathing),
    "swinging_zero": _kind(
        "The cell's zero swings with the room: c sin(5 pi tau) over the session.", None,
        "load_cell time", (0.05, 3.0, "mN"), _felt(_swinging)),
    "outer_face": _kind(
        "The picture shows the face towards which the sheet's end points, c from its middle.",
        None, "camera", (0.1, 2.0, "mm"), _outer_face),
    "barrel": _kind(
        "The lens widens the picture by c r^2/(25 mm)^2 about a point 25 mm from the clamp.", None,
        "camera", (0.005, 0.2, "-"), _barrel),
    "sinking_camera": _kind(
        "The camera sinks: the picture moves along y by c over the session.", None, "camera time",
        (0.05, 3.0, "mm"), _sinking),
}  # fmt: skip

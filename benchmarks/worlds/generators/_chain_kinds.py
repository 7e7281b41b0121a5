"""What the world `chain` can hide, in its own words and formulas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.generators import _chain_camera as camera
from benchmarks.worlds.generators import _chain_course as course
from benchmarks.worlds.generators import _chain_rig as rig
from benchmarks.worlds.generators import _chain_sheet as sheet
from benchmarks.worlds.generators._chain_plant import Plant

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


KINDS: dict[str, Kind] = {
    # what the catalogue has
    "starved_electrode": _kind(
        "The electrodes starve: EIBM as 1/(1 + c s/50 mm).", "nonuniform_eibm", "eibm",
        (0.5, 30.0, "-"), sheet.starved),
    "curled": _kind(
        "The sheet at rest is more curved than stated by c, everywhere.", "initial_curvature",
        "rest_curvature", (1.0, 12.0, "1/m"), sheet.more_curved,
        lambda c: {"curvature_error_per_m": c}),
    "graded": _kind(
        "Stiffness grows as 1 + c s/l.", "nonuniform_stiffness", "compliance", (0.2, 5.0, "-"),
        sheet.graded, lambda c: {"relative_change": c}),
    "stiffening": _kind(
        "Bending u = v/(1 + 4 c (v/10 per m)^2)^(1/4), v the moment over B.", "nonlinear_stiffness",
        "compliance", (0.02, 0.3, "-"), sheet.stiffening),
    "drying": _kind(
        "Stiffness goes as exp(c (tau - 1/2)) over the session.", "stiffness_drift", "time",
        (0.1, 0.7, "-"), course.drying),
    "wearing": _kind(
        "EIBM goes as 1 + c (tau - 1/2) over the session.", "eibm_drift", "time", (0.1, 1.4, "-"),
        course.wearing, lambda c: {"relative_change": c}),
    "wearing_late": _kind(
        "The EIBM goes as 1 + c (tau^3 - 1/4) over the session.", "eibm_drift", "time",
        (0.1, 1.3, "-"), course.wearing_late),
    "yielding": _kind(
        "Stiffness goes as ((t + 0.3 s)/5 s)^-c in each run.", "viscoelastic_creep", "time",
        (0.02, 0.4, "-"), course.yielding),
    "slow_charge": _kind(
        "EIBM follows the voltage's rise by a first-order lag of c.", "charging_lag", "time",
        (0.08, 1.0, "s"), course.slow, lambda c: {"time_constant_s": c}, needs="series"),
    "relaxing": _kind(
        "Of the EIBM c (1 - exp(-(t/0.6 s)^0.7)) is lost in each pulse.", "back_relaxation", "time",
        (0.1, 0.8, "-"), course.relaxing, needs="series"),
    "waking": _kind(
        "Pulse k has the EIBM 1 - c/(1 + k)^1.5 of the settled one.", "first_pulse_transient",
        "time", (0.2, 1.0, "-"), course.waking, needs="series"),
    "heavy": _kind(
        "The rig leans, and a weight c per length acts along -y.", "gravity", "even_moment",
        (0.003, 0.1, "N/m"), rig.put("weight_N_per_m"), lambda c: {"load_N_per_m": c}),
    "meniscus": _kind(
        "Water pulls the short sheet's roll by c along the normal.", "surface_tension",
        "load_cell", (0.1, 3.0, "mN"), rig.felt(rig.wet), lambda c: {"force_mN": c}),
    "drying_rolls": _kind(
        "Water pulls either sheet's roll by c (1 - tau/2) along the normal.", "surface_tension",
        "load_cell", (0.1, 3.0, "mN"), rig.felt(rig.drying_rolls)),
    "loose_clamp": _kind(
        "The clamp turns by c times the load's moment.", "clamp_compliance", "compliance",
        (30.0, 5e3, "rad/(N m)"), rig.put("clamp_give_rad_per_Nm"),
        lambda c: {"rotation_rad_per_Nm": c}),
    "crooked_clamp": _kind(
        "The sheet leaves the clamp at an angle c.", "clamp_angle",
        "rest_curvature position camera", (0.01, 0.2, "rad"), rig.put("clamp_angle_rad"),
        lambda c: {"angle_rad": c}),
    "rubbing": _kind(
        "The rolls drag along the sheet with c |N|, each polarity against the other's way.",
        "roll_friction", "position load_cell", (0.1, 0.8, "-"), rig.put("friction")),
    "thick_rolls": _kind(
        "The sheet passes the arc's point at a distance c along its normal.", "roll_offset",
        "position", (0.3, 3.0, "mm"), rig.put("beside_m", 1e-3), lambda c: {"offset_mm": c}),
    "sticking": _kind(
        "From 20 mm on the rolls hold back c of the force.", "roll_sticking", "position load_cell",
        (0.1, 2.0, "mN"), rig.felt(rig.stuck)),
    "jerking": _kind(
        "From 15 mm on the rolls hold back a change of the force, and let go by 3 c/5 at c each.",
        "roll_sticking", "position load_cell", (0.1, 2.0, "mN"), rig.felt(rig.jerked)),
    "tight_bearings": _kind(
        "The rolls' bearings drag along the sheet with c, outwards but at the negative polarity.",
        "roll_friction", "position load_cell", (0.05, 3.0, "mN"), rig.felt(rig.dragged)),
    "zero": _kind(
        "The cell's zero is c.", "force_offset", "load_cell", (0.05, 5.0, "mN"),
        rig.felt(lambda c, _, size: np.full(len(c.time_s), size)), lambda c: {"force_mN": c}),
    "warming_cell": _kind(
        "The cell's zero rises as c sqrt(tau) over the session.", "force_drift", "load_cell",
        (0.15, 5.0, "mN"), rig.felt(lambda c, _, size: size * np.sqrt(c.session))),
    "askew_cell": _kind(
        "The cell's axis is turned by c: it shows N cos(gamma - c).", "load_cell_misalignment",
        "load_cell", (0.06, 0.6, "rad"), rig.felt(rig.turned), lambda c: {"angle_rad": c}),
    "play": _kind(
        "The cell follows its load with a play of c to either side.", "load_cell_hysteresis",
        "load_cell", (0.05, 1.0, "mN"), rig.felt(rig.behind), lambda c: {"force_mN": c}),
    "soft_cell": _kind(
        "The cell gives way along the arc by c times the force.", "load_cell_compliance",
        "load_cell position", (0.2, 3.0, "mm/mN"), rig.put("cell_give_m_per_N"),
        lambda c: {"compliance_mm_per_mN": c}),
    "wrong_place": _kind(
        "The cell stands c farther along the arc than stated.", "position_error", "position",
        (0.3, 6.0, "mm"), rig.moved, lambda c: {"offset_mm": c}),
    "wrong_scale": _kind(
        "Lengths in the picture are 1 + c of the true ones.", "camera_scale", "camera",
        (0.005, 0.3, "-"), camera.larger, lambda c: {"relative_error": c}),
    "tilted_camera": _kind(
        "The picture is r/(1 - c x/50 mm).", "camera_perspective", "camera", (0.005, 0.3, "-"),
        camera.tilted),
    "late_picture": _kind(
        "A picture is c older than its reading.", "frame_delay", "camera time", (0.25, 0.49, "s"),
        rig.put("late_s"), lambda c: {"delay_s": c}),
    # what no catalogue has
    "strong_patch": _kind(
        "A patch at 22 mm, 6 mm wide, has 1 + c of the EIBM.", None, "eibm", (0.3, 8.0, "-"),
        sheet.patch),
    "kink": _kind(
        "The long sheet has a kink: c more curved within 3 mm at 30 mm.", None, "rest_curvature",
        (5.0, 60.0, "1/m"), sheet.kinked),
    "crease": _kind(
        "The long sheet is creased at 18 mm: there its compliance is 1 + c.", None, "compliance",
        (1.0, 30.0, "-"), sheet.creased),
    "squeezed_root": _kind(
        "A moment that goes with V^2 and falls as exp(-s/6 mm): c at 2 V.", None,
        "even_moment eibm", (2.0, 60.0, "1/m"), sheet.squeezed),
    "ringing": _kind(
        "After each edge the EIBM rings: 1 + c exp(-t/0.25 s) sin(2 pi t/0.17 s).", None, "time",
        (0.1, 1.0, "-"), course.ringing, needs="series"),
    "crack": _kind(
        "After 62 % of the session the electrode cracks: c of the EIBM is lost at once.", None,
        "time", (0.05, 0.6, "-"), course.cracking),
    "stutter": _kind(
        "Two pulses stronger, two weaker, by c from one to the other.", None, "time",
        (0.03, 0.6, "-"), course.stuttering, needs="series"),
    "charged_stiff": _kind(
        "The sheet is stiffer by c under 2 V, whatever the sign.", None, "compliance eibm",
        (0.1, 1.0, "-"), course.charged_stiff),
    "stiff_anode": _kind(
        "The sheet is stiffer by c under +2 V, and not under -2 V.", None, "compliance eibm",
        (0.1, 1.5, "-"), course.stiff_anode),
    "one_sided": _kind(
        "Bending u = v/(1 + c (1 + tanh(v/6 per m))/2), v the moment over B: stiffer one way.",
        None, "compliance", (0.1, 1.5, "-"), sheet.one_sided),
    "wetter_outwards": _kind(
        "Wet rolls soften more of the sheet the farther out they stand: B (1 - c (p/30 mm)^0.7).",
        None, "compliance position", (0.05, 0.7, "-"), course.wetter_outwards),
    "lead_screw": _kind(
        "The stage's screw errs by c sin(2 pi p/14 mm).", None, "position", (0.2, 4.0, "mm"),
        rig.screw),
    "bent_scale": _kind(
        "The cell shows F + c F |F|, F in mN.", None, "load_cell", (0.02, 0.3, "1/mN"),
        rig.felt(rig.cubic)),
    "cable": _kind(
        "The cell's cable pulls by c cos(2 pi p/20 mm).", None, "load_cell position",
        (0.1, 3.0, "mN"), rig.felt(rig.cable)),
    "backlash": _kind(
        "The stage has backlash: every second position is c farther than the others.", None,
        "position", (0.3, 4.0, "mm"), rig.backlash),
    "knocked_stage": _kind(
        "Somebody knocks the stage: from 20 to 45 % of the session it stands c farther.", None,
        "position time", (0.3, 4.0, "mm"), rig.knocked),
    "breathing": _kind(
        "The EIBM swings by c sin(5 pi tau) over the session.", None, "time", (0.05, 0.6, "-"),
        course.breathing),
    "swinging_zero": _kind(
        "The cell's zero swings with the room: c sin(5 pi tau) over the session.", None,
        "load_cell time", (0.05, 3.0, "mN"), rig.felt(rig.swinging)),
    "outer_face": _kind(
        "The picture shows the face towards which the sheet's end points, c from its middle.",
        None, "camera", (0.1, 2.0, "mm"), camera.outer_face),
    "barrel": _kind(
        "The lens widens the picture by c r^2/(25 mm)^2 about a point 25 mm from the clamp.", None,
        "camera", (0.005, 0.2, "-"), camera.barrel),
    "sinking_camera": _kind(
        "The camera sinks: the picture moves along y by c over the session.", None, "camera time",
        (0.05, 3.0, "mm"), camera.sinking),
}  # fmt: skip

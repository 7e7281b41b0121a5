"""Forms of the catalogue's effects of clamp, rolls, load cell, stage and camera."""

from __future__ import annotations

import math
from dataclasses import replace

from benchmarks.hidden_effects.forms import Change, Form, set_to
from benchmarks.hidden_effects.recipe import Recipe

SESSION_S = 14 * 60.0
MIDDLE_MM = 15.0


def _wet(dries_s: float) -> Change:
    """Water between the rolls and the short sheet's elongation."""

    def change(recipe: Recipe, force_mN: float) -> None:
        recipe.set("rolls.meniscus_mN", force_mN)
        recipe.set("rolls.meniscus_dries_s", dries_s)
        recipe.set("configurations.long.meniscus_share", 0.0)

    return change


def _sticking(recipe: Recipe, force_mN: float) -> None:
    recipe.set("rolls.stick_mN", force_mN)
    recipe.set("rolls.stick_from_mm", MIDDLE_MM)


def _offset(recipe: Recipe, force_mN: float) -> None:
    sensitivity = recipe.world["load_cell"]["sensitivity_V_per_N"]
    recipe.set("load_cell.offset_uV", force_mN * 1e-3 * sensitivity * 1e6)


def _warming(form: str, time_s: float) -> Change:
    """The zero goes by the size over the session."""

    def change(recipe: Recipe, force_mN: float) -> None:
        past = SESSION_S / time_s
        whole = {"line": past, "root": math.sqrt(past), "exp": -math.expm1(-past)}[form]
        recipe.set("load_cell.warming_mN", force_mN / whole)
        recipe.set("load_cell.warming_s", time_s)
        recipe.set("load_cell.warming_form", form)

    return change


def _loop(reach_mN: float) -> Change:
    def change(recipe: Recipe, force_mN: float) -> None:
        recipe.set("load_cell.hysteresis_mN", force_mN)
        recipe.set("load_cell.hysteresis_reach_mN", reach_mN)

    return change


def _arc_zero(recipe: Recipe, offset_mm: float) -> None:
    recipe.set("arc.origin_deg", math.degrees(offset_mm / recipe.world["arc"]["radius_mm"]))


_TENSION = Form(
    "surface_tension", "stays", "mN on the short sheet", 0.4, 2.0, _wet(0.0), "load_cell",
    parameters=lambda f: {"force_mN": f},
)  # fmt: skip
_FORCE_OFFSET = Form(
    "force_offset", "constant", "mN", 0.3, 2.0, _offset, "load_cell",
    parameters=lambda f: {"force_mN": f},
)  # fmt: skip
_FORCE_DRIFT = Form(
    "force_drift", "line", "mN over the session", 0.6, 3.0, _warming("line", 600.0), "load_cell",
    accepted=("time",), parameters=lambda f: {"force_mN": f},
)  # fmt: skip
_HYSTERESIS = Form(
    "load_cell_hysteresis", "play", "half the height of the loop, mN", 0.25, 1.0, _loop(0.5),
    "load_cell", parameters=lambda f: {"force_mN": f},
)  # fmt: skip
_POSITION = Form(
    "position_error", "offset", "mm further than stated", 1.0, 4.0, _arc_zero, "position",
    parameters=lambda o: {"offset_mm": o},
)  # fmt: skip
_SCALE = Form(
    "camera_scale", "both", "lengths look relatively so much longer", 0.03, 0.2,
    set_to("view.scale_error"), "camera", felt_by="curve",
    parameters=lambda e: {"relative_error": e},
)  # fmt: skip
_ROLL = Form(
    "camera_roll", "turned", "rad that pictures are turned", 0.03, 0.2,
    set_to("view.roll_rad"), "camera", felt_by="curve", accepted=("rest_curvature",),
    parameters=lambda a: {"angle_rad": a},
)  # fmt: skip
_PERSPECTIVE = Form(
    "camera_perspective", "along_x", "lengths look so much longer 50 mm away", 0.05, 0.3,
    set_to("view.perspective_x"), "camera", felt_by="curve",
    parameters=lambda e: {"relative_error": e},
)  # fmt: skip

FORMS: tuple[Form, ...] = (
    _TENSION,
    replace(_TENSION, form="dries", change=_wet(12.0)),
    Form("clamp_compliance", "linear", "rad per N m", 150.0, 5000.0,
         set_to("clamp.compliance_mrad_per_Nmm"), "compliance", place_mm=(0.0, 2.0),
         parameters=lambda c: {"rotation_rad_per_Nm": c}),
    Form("clamp_angle", "tilt", "rad", 0.02, 0.2, set_to("clamp.tilt_rad"), "rest_curvature",
         accepted=("position", "camera"), place_mm=(0.0, 2.0),
         parameters=lambda a: {"angle_rad": a}),
    Form("roll_friction", "sliding", "tangential over normal force", 0.2, 0.5,
         set_to("rolls.friction"), "position", parameters=lambda c: {"coefficient": c}),
    Form("roll_sticking", "from_the_middle", "mN", 0.3, 2.0, _sticking, "position",
         parameters=lambda f: {"force_mN": f, "from_position_mm": MIDDLE_MM}),
    Form("roll_offset", "above", "mm", 0.8, 4.0, set_to("rolls.offset_mm"), "position",
         parameters=lambda o: {"offset_mm": o}),
    _FORCE_OFFSET,
    replace(_FORCE_OFFSET, form="soon_settled", change=_warming("exp", 40.0)),
    _FORCE_DRIFT,
    replace(_FORCE_DRIFT, form="exp", change=_warming("exp", 300.0)),
    replace(_FORCE_DRIFT, form="root", change=_warming("root", 600.0)),
    Form("load_cell_misalignment", "turned", "rad", 0.2, 0.7,
         lambda r, a: r.set("load_cell.misalignment_deg", math.degrees(a)), "load_cell",
         parameters=lambda a: {"angle_rad": a}),
    _HYSTERESIS,
    # one that does not turn over within the swing of the force would be a gain, which B takes up
    replace(_HYSTERESIS, form="soft", change=_loop(1.0), size=0.6),
    Form("load_cell_compliance", "linear", "mm per mN", 0.5, 3.0,
         set_to("load_cell.compliance_mm_per_mN"), "load_cell", accepted=("position",),
         parameters=lambda c: {"compliance_mm_per_mN": c}),
    _POSITION,
    replace(_POSITION, form="scale", unit="mm further than stated at 15 mm",
            change=set_to("arc.scale_error", 1 / MIDDLE_MM), parameters=lambda _: {}),
    _SCALE,
    replace(_SCALE, form="stretched", change=set_to("view.stretch"), parameters=lambda _: {}),
    _ROLL,
    _PERSPECTIVE,
    replace(_PERSPECTIVE, form="along_y", change=set_to("view.perspective_y")),
    Form("frame_delay", "late", "s", 0.42, 0.9, set_to("frame_delay_s"), "camera",
         accepted=("time",), felt_by="curve", parameters=lambda t: {"delay_s": t}),
)  # fmt: skip

"""Effects that no catalogue has: one or more for each slot, with their true place."""

from __future__ import annotations

from benchmarks.hidden_effects.forms import Change, Form, set_to


def _bump(of: str, at_mm: float, width_mm: float, sign: float = 1.0) -> Change:
    return lambda recipe, size: recipe.bump(of, at_mm, width_mm, sign * size, "long")


FORMS: tuple[Form, ...] = (
    Form("local_rest_curvature", "kink", "per m", 15.0, 150.0,
         _bump("rest_curvature", 22.0, 2.0), "rest_curvature", place_mm=(18.0, 26.0)),
    Form("local_eibm", "bump", "per m, over B", 25.0, 200.0,
         _bump("eibm", 30.0, 4.0), "eibm", place_mm=(22.0, 38.0)),
    Form("dead_electrode", "hole", "per m, over B", 20.0, 28.0,
         _bump("eibm", 12.0, 3.0, -1.0), "eibm", place_mm=(6.0, 18.0)),
    Form("even_moment_patch", "bump", "per m at 2 V, over B", 15.0, 150.0,
         _bump("even_moment", 18.0, 5.0), "even_moment", place_mm=(8.0, 28.0)),
    Form("stiff_patch", "bump", "relative", 2.0, 20.0,
         _bump("stiffness", 14.0, 2.0), "compliance", place_mm=(10.0, 18.0)),
    Form("crack", "notch", "relative loss of B", 0.8, 0.95,
         _bump("stiffness", 10.0, 0.6, -1.0), "compliance", place_mm=(8.0, 12.0)),
    Form("screw_error", "wave", "mm", 0.8, 2.0, set_to("arc.screw_mm"), "position"),
    Form("slipped_stage", "step", "mm from 20 mm on", 1.0, 4.0, set_to("arc.slip_mm"), "position"),
    Form("cable_pull", "square", "mN at 30 mm", 0.8, 4.0, set_to("load_cell.cable_mN"),
         "load_cell"),
    Form("voltage_pickup", "line", "mN at 2 V", 0.3, 2.0, set_to("load_cell.pickup_mN"),
         "load_cell"),
    Form("beating_cell", "wave", "mN", 0.5, 2.0, set_to("load_cell.beat_mN"), "load_cell",
         accepted=("time",)),
    Form("breathing_eibm", "wave", "relative", 0.3, 0.8, set_to("eibm.breathing"), "time",
         accepted=("eibm",)),
    Form("dented_lens", "dent", "mm", 0.5, 4.0, set_to("view.dent_mm"), "camera",
         felt_by="curve", place_mm=(35.0, 50.0)),
)  # fmt: skip

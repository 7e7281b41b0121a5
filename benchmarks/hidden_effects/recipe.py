"""A world and what its sheet.toml says of it, while effects are being put in."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.hidden_effects.cases import Case, Rest
from model import SheetGeometry
from sim_hardware.world import WorldSettings, load_world

LONG, SHORT = "long", "short"
BOTH = (LONG, SHORT)
# Me/B in 1/m at +2 V: what the paper's forces and shapes need when it is constant along the sheet.
EIBM_LONG_PER_M, EIBM_SHORT_PER_M = 30.0, 80.0
NEGATIVE_RATIO = 0.8
RISE_S = 0.03
AT_ONCE_S = 1e-6
NODE_M = 5e-3


@dataclass
class Recipe:
    """`world` are the tables of a world.toml; `stated` k0 as (s in m, values in 1/m)."""

    case: Case
    world: dict[str, Any]
    stated: dict[str, tuple[np.ndarray, np.ndarray]]

    def set(self, key: str, value: Any) -> None:
        """Set a key such as `eibm.decay_mm`; NAME in it stands for both configurations."""
        for name in BOTH if "NAME" in key else ("",):
            *tables, last = key.replace("NAME", name).split(".")
            table = self.world
            for part in tables:
                table = table[part]
            if last not in table:
                raise KeyError(key)
            table[last] = value

    def settings(self) -> WorldSettings:
        """The world as it is now."""
        return WorldSettings.model_validate(self.world)

    def bump(self, of: str, at_mm: float, width_mm: float, amount: float, name: str = "") -> None:
        """Make a place along the sheet unlike its neighbours."""
        self.world["bumps"].append(
            {
                "of": of,
                "at_mm": at_mm,
                "width_mm": width_mm,
                "amount": amount,
                "configuration": name,
            }
        )

    def weigh_moment(self, name: str, by: float) -> None:
        """Multiply the EIBM of a configuration."""
        self.world["configurations"][name]["eibm_ratio"] *= by

    def weigh_stiffness(self, name: str, by: float) -> None:
        """Multiply B of a configuration, and leave the EIBM as it is."""
        self.world["configurations"][name]["youngs_modulus_MPa"] *= by
        self.weigh_moment(name, 1 / by)


def base_recipe(case: Case) -> Recipe:
    """A world that is exactly the base model, but for noise and scatter."""
    recipe = Recipe(case, load_world(seed=case.seed).model_dump(), {})
    for key, value in _BASE.items():
        recipe.set(key, value)
    recipe.set("eibm.negative_ratio", 1.0 if case.symmetric else NEGATIVE_RATIO)
    recipe.set("configurations.short.eibm_ratio", EIBM_SHORT_PER_M / EIBM_LONG_PER_M)
    for key in ("eibm", "stiffness", "position_mm"):
        recipe.world["scatter"][key] *= case.scatter
    if case.correlated:
        recipe.set("load_cell.drift_mN", 0.08)
        recipe.set("load_cell.drift_shortest_s", 4.0)
    _bend(recipe, case.rest)
    return recipe


_BASE: dict[str, float] = {
    "eibm.curvature_per_m": EIBM_LONG_PER_M,
    "eibm.decay_mm": 0.0,
    "eibm.saturation_V": 1e3,  # Me goes with the voltage across the sheet
    "eibm.build_up_s": AT_ONCE_S,
    "electrical.rise_time_s": RISE_S,
    "water.first_pulse_deficit": 0.0,
    "water.stiffening_per_min": 0.0,
    "water.weakening_per_min": 0.0,
    "amplifier.offset_mV": 0.0,
    "amplifier.lag_ms": AT_ONCE_S * 1e3,
    "load_cell.offset_uV": 0.0,
    "load_cell.nonlinearity": 0.0,
    "load_cell.hysteresis_mN": 0.0,
    "load_cell.hum_mN": 0.0,
    "chain.step_ms": 5.0,  # edges lie on its steps
}


def _bend(recipe: Recipe, rest: Rest) -> None:
    """Give the long sheet its rest curvature, and state what it is."""
    if rest == "nodes":
        recipe.set("configurations.long.rest_curvature_step_mm", 10.0)
    if rest == "constant":
        recipe.set("configurations.long.rest_curvature_decay_mm", 0.0)
        recipe.set("configurations.long.rest_curvature_per_m", 15.0)
    world = recipe.settings()
    for name in BOTH:
        sheet = world.configurations[name]
        length = sheet.free_length_m
        step = {"nodes": 10e-3, "constant": length, "exp": NODE_M}[rest] if name == LONG else length
        nodes = np.linspace(0.0, length, 1 + round(length / step))
        recipe.stated[name] = nodes, _best_line(nodes, sheet.rest_curvature)


def _best_line(nodes: np.ndarray, along: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """Values at the nodes whose straight lines come nearest to a function, to 0.01 per m."""
    s = (np.arange(2000) + 0.5) / 2000 * nodes[-1]
    hats = np.stack([np.interp(s, nodes, row) for row in np.eye(len(nodes))], axis=1)
    values: np.ndarray = np.linalg.lstsq(hats, along(s), rcond=None)[0]
    return np.round(values, 2)


def geometry(recipe: Recipe) -> dict[str, SheetGeometry]:
    """What sheet.toml says."""
    world = recipe.settings()
    return {
        name: SheetGeometry(
            configuration=name,
            free_length_m=sheet.free_length_m,
            width_m=sheet.width_mm / 1e3,
            thickness_m=sheet.thickness_mm / 1e3,
            elongation_m=sheet.elongation_m,
            arc_radius_m=world.arc.radius_mm / 1e3,
            arc_origin_rad=0.0,
            initial_curvature=recipe.stated[name],
            rise_time_s=RISE_S,
        )
        for name, sheet in world.configurations.items()
    }

"""Chains and sheets of a moving world, for its tests."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sim_hardware.world import WorldSettings, load_world
from sim_hardware.world.motion import march
from sim_hardware.world.motion.links import Links, room
from sim_hardware.world.motion.moving_sheet import MovingSheet
from sim_hardware.world.setup import MountedSheet, Scatter

REFERENCE = Path(__file__).parents[1] / "data" / "reference" / "dynamics"
B, MU, L, R = 1.27e-6, 5.775e-3, 0.05, 0.04
Floats = np.ndarray


def rows(name: str) -> list[dict[str, float]]:
    with (REFERENCE / name).open(encoding="utf-8") as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def straight(n: int, length_m: float = L, **more: object) -> Links:
    """The sheet of the reference tables in a vacuum, cut into n links."""
    h = length_m / n
    clamped = np.concatenate(([0.0], np.ones(n)))
    values = {
        "h_m": h, "rest_rad": 0 * clamped, "spring_Nm": B / h * clamped,
        "mass_kg": MU * h * clamped, "span_m": h * clamped,
        "bar_at_m": np.zeros(2), "bar_kg": np.zeros(2), "bar_span_m": np.zeros(2),
        "viscous_s": 0.0, "share": np.zeros(0), "relax_s": np.zeros(0),
        "added_kg_per_m": 0.0, "normal_Ns_per_m2": 0.0, "quadratic_Ns2_per_m3": 0.0,
        "tangential_Ns_per_m2": 0.0, "load_N_per_m": 0.0,
    }  # fmt: skip
    return Links(**{**values, **more})  # type: ignore[arg-type]


def world(links: int = 64, step_ms: float = 0.5, **tables: dict[str, object]) -> WorldSettings:
    """The shipped moving world with the long sheet of the reference tables, in a vacuum."""
    content = load_world(Path("moving.toml")).model_dump()
    content["chain"].update(moving_links=links, moving_step_ms=step_ms)
    content["configurations"]["long"]["youngs_modulus_MPa"] = B * 12e-6 / (0.011 * 0.21e-3**3)
    tables = {"water": {"fluid": "none"}, "eibm": {"negative_ratio": 1.0}, **tables}
    for name, table in tables.items():
        content[name] = {**content[name], **table}
    return WorldSettings.model_validate(content)


def sheet(settings: WorldSettings, position_m: float | None, name: str = "long") -> MovingSheet:
    return MovingSheet(
        setup=MountedSheet(
            settings=settings, configuration=name, position_m=position_m, scatter=Scatter()
        )
    )


@dataclass
class Driven:
    """A sheet under a voltage: rows and angles at 0, dt, 2 dt, ..."""

    sheet: MovingSheet
    rows: Floats
    phi_rad: Floats
    current_A: Floats

    def tip_m(self) -> Floats:
        last = self.phi_rad.shape[1] - 1
        beyond = np.repeat(self.phi_rad[:, -1:], self.sheet.chain.links - last - 1, axis=1)
        phi, end = np.hstack((self.phi_rad, beyond)), np.array([self.sheet.chain.sheet.visible_m])
        return np.array([self.sheet.chain.curve(one, end)[0] for one in phi])


def driven(one: MovingSheet, drive_V: Floats, start_V: float | None = None) -> Driven:
    """The sheet from rest under a voltage that is held over each step."""
    settings, n = one.setup.settings, one.cells
    U = np.zeros(n) if start_V is None else np.full(n, start_V)
    state = one.at_rest(U, 1.0, 1.0, beside_N=0.0, held_N=0.0)
    even, at = np.ones(drive_V.size), one.setup.position_m
    polar = 0.0 if at is None else one.setup.arc_rad
    course = march.Course(
        drive_V, even, even, polar * even, 0 * even, 0 * even,
        R * np.cos(polar) * even, R * np.sin(polar) * even, 0 * even,
    )  # fmt: skip
    first, angles = state.row.copy(), state.phi[1].copy()
    found = np.empty((drive_V.size, march.COLUMNS))
    phi = np.empty((drive_V.size, n + 1))
    cell = settings.load_cell
    made = march.march(
        one.links, one.line, one.law, 2 * np.pi * cell.resonance_hz, cell.damping, one.step_s,
        one.chain.sheet.visible_m, course, state, room(n), found, phi,
    )  # fmt: skip
    assert made == drive_V.size
    found = np.vstack((first, found))
    phi = np.vstack((angles, angles, phi))[:-1]  # a row's angles are those a step after it
    held_V = np.concatenate(([0.0], drive_V))
    return Driven(one, found, phi, one.line.now_S * held_V - found[:, march.BACK])

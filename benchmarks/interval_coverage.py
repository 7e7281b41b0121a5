"""How often the stated 90 % intervals of B and EIBM hold the truth, and how wide they are.

Sessions are simulated without pixels and volts by the world of `sim_hardware`, a chain of rigid
links that shares no code with the model; its EIBM falls along the sheet. k0 is stated as a person
would, in nodes every 10 mm rounded to 0.1 per m.

    python -m benchmarks.interval_coverage [SESSIONS] [WORLD.toml] [FIRST_SEED] [--few]

With `--few` sessions of the long sheet alone, with two or three positions or with one voltage.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model import Condition, Curve, FitOptions, Measurements, Reading, SheetGeometry
from model.identification.joint import joint_fit
from model.identification.observations import observe
from sim_hardware.world import WorldSettings, load_world
from sim_hardware.world.reduced import POSITIONS_M, VOLTAGES, ReducedSession, reduced_session

Z90 = 1.6449


@dataclass(frozen=True, kw_only=True)
class Extent:
    """What is measured in a session."""

    configurations: Sequence[str] = ("long", "short")
    positions: Sequence[int] = range(len(POSITIONS_M))  # of POSITIONS_M
    voltages: Sequence[float] = VOLTAGES


WHOLE = Extent()
FEW = {
    "three positions": Extent(configurations=("long",), positions=(1, 3, 5)),
    "three positions, +2 V alone": Extent(
        configurations=("long",), positions=(0, 3, 6), voltages=(2.0,)
    ),
    "three in a row, +2 V alone": Extent(
        configurations=("long",), positions=(2, 3, 4), voltages=(2.0,)
    ),
    "two positions": Extent(configurations=("long",), positions=(1, 5)),
    "seven positions, +2 V alone": Extent(configurations=("long",), voltages=(2.0,)),
    "seven positions": Extent(configurations=("long",)),
}


@dataclass(frozen=True)
class Tally:
    """Arrays (sessions, quantities)."""

    names: list[str]
    error: np.ndarray  # relative
    sigma: np.ndarray  # relative
    inside: np.ndarray  # whether the interval holds the truth
    width: np.ndarray  # of the interval, relative


def measurements(session: ReducedSession, world: WorldSettings) -> Measurements:
    """As the rig would hand it to `fit`."""
    conditions = []
    for c in session.conditions:
        kind = "kept" if c.voltage_V else "zero"
        readings = tuple(
            Reading(index=i, kind=kind, force_N=float(f)) for i, f in enumerate(c.forces_N)
        )
        sigma = np.full(len(c.s_m), c.curve_sigma_m)
        curve = Curve(s_m=c.s_m, x_m=c.x_m, y_m=c.y_m, sigma_m=sigma)
        conditions.append(
            Condition(
                configuration=c.configuration,
                position_m=c.position_m,
                voltage_V=c.voltage_V,
                readings=readings,
                curve=curve,
            )
        )
    names = dict.fromkeys(c.configuration for c in session.conditions)
    return Measurements(sheets={n: geometry(world, n) for n in names}, conditions=tuple(conditions))


def geometry(world: WorldSettings, name: str) -> SheetGeometry:
    """sheet.toml as a person would write it."""
    sheet = world.configurations[name]
    length = sheet.free_length_m
    s = np.linspace(0.0, length, 6) if length > 0.02 else np.zeros(1)
    rest = np.round(np.asarray(sheet.rest_curvature(s)), 1)
    return SheetGeometry(
        configuration=name,
        free_length_m=length,
        width_m=sheet.width_mm * 1e-3,
        thickness_m=sheet.thickness_mm * 1e-3,
        elongation_m=sheet.elongation_m,
        arc_radius_m=world.arc.radius_mm * 1e-3,
        arc_origin_rad=float(np.radians(world.arc.origin_deg)),
        initial_curvature=(s, rest),
    )


def tally(world: WorldSettings, seeds: Iterable[int], extent: Extent = WHOLE) -> Tally:
    """Fit one session for each seed."""
    names: list[str] = []
    rows = []
    for seed in seeds:
        session = reduced_session(
            world,
            seed=seed,
            configurations=extent.configurations,
            positions_m=[POSITIONS_M[i] for i in extent.positions],
            voltages=extent.voltages,
        )
        data = measurements(session, world)
        joint = joint_fit(data, [observe(data, n) for n in data.sheets], FitOptions())
        found = []
        for n, name in enumerate(data.sheets):
            found.append((f"{name} B", joint.stiffness(n), session.B_Nm2[name]))
            for volts in filter(None, sorted(extent.voltages, reverse=True)):
                truth = session.mean_eibm_Nm[name, volts]
                found.append((f"{name} EIBM {volts:+g} V", joint.constant_eibm(n, volts), truth))
        names = [name for name, _, _ in found]
        row = []
        for _, parameter, truth in found:
            low, high = parameter.interval()
            width = (high - low) / abs(parameter.value)
            error = parameter.value / truth - 1.0
            row.append((error, parameter.sigma / abs(truth), low <= truth <= high, width))
        rows.append(row)
    error, sigma, inside, width = np.moveaxis(np.array(rows, dtype=float), 2, 0)
    return Tally(names, error, sigma, inside, width)


def wilson(share: float, count: int) -> tuple[float, float]:
    """90 % interval of a share."""
    z = Z90**2 / count
    middle = (share + z / 2) / (1 + z)
    half = np.sqrt(share * (1 - share) * z + z**2 / 4) / (1 + z)
    return middle - half, middle + half


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sessions", type=int, nargs="?", default=200)
    parser.add_argument("world", nargs="?", default="", help="a world file; '': the shipped one")
    parser.add_argument("first", type=int, nargs="?", default=1000, help="seed")
    parser.add_argument("--few", action="store_true", help="sessions of few set-ups")
    chosen = parser.parse_args()
    world = load_world(Path(chosen.world) if chosen.world else None)
    for name, extent in (FEW if chosen.few else {"whole": WHOLE}).items():
        _show(name, world, chosen.sessions, chosen.first, extent)


def _show(what: str, world: WorldSettings, count: int, first: int, extent: Extent) -> None:
    start = time.perf_counter()
    found = tally(world, range(first, first + count), extent)
    each = (time.perf_counter() - start) / count
    print(f"{what}: {count} sessions from seed {first} on, {each:.2f} s each")
    print(f"{'':18} {'bias %':>7} {'scatter %':>9} {'stated %':>8} {'covered':>8} {'width %':>8}")
    for i, name in enumerate(found.names):
        share = float(np.mean(found.inside[:, i]))
        low, high = wilson(share, count)
        print(
            f"{name:18} {100 * found.error[:, i].mean():7.2f} {100 * found.error[:, i].std():9.2f}"
            f" {100 * found.sigma[:, i].mean():8.2f} {share:8.3f}"
            f" {100 * found.width[:, i].mean():8.2f}   ({low:.3f} .. {high:.3f})"
        )
    print(f"all: covered {np.mean(found.inside):.3f}, widest {100 * np.max(found.width):.1f} %")


if __name__ == "__main__":
    main()

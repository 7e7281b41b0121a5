"""Fits of sheets that are bent to a ring, in the world of `sim_hardware`, a chain of rigid links.

    python -m benchmarks.bent_to_a_ring [SHEETS] [FIRST_SEED]

Initial curvature, EIBM and the arc's radius are drawn at random, so that the sheet turns by 170 to
350 degrees at one of its voltages; five positions, three voltages, the noise and scatter of the
shipped world. *Found*: B and both mean EIBMs within 5 %, and curves within 0.2 mm (RMS).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping

import numpy as np

from benchmarks.interval_coverage import measurements
from model import FitOptions, ModelError, Parameter, fit
from sim_hardware.world import WorldSettings, load_world
from sim_hardware.world.reduced import ReducedSession, reduced_session

LEAST_DEG, MOST_DEG = 170.0, 350.0
NEAR, CURVE_M = 0.05, 2e-4
POSITIONS, LEAST_REACHED = 5, 12  # of 15 conditions


def main() -> None:
    """Print a line for each sheet, and how many were found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sheets", type=int, nargs="?", default=30)
    parser.add_argument("first_seed", type=int, nargs="?", default=0)
    options = parser.parse_args()
    found = 0
    for seed in range(options.first_seed, options.first_seed + options.sheets):
        world = bent_world(np.random.default_rng(seed))
        session = session_of(world, seed)
        said, is_right = fitted(session, world)
        found += is_right
        print(f"{seed}: turns by {_turn_deg(world, session):.0f} degrees: {said}", flush=True)
    print(f"{found} of {options.sheets} were found")


def bent_world(random: np.random.Generator) -> WorldSettings:
    """Return the shipped world with a long sheet and an arc drawn until it is bent enough."""
    world = load_world()
    while True:
        long = world.configurations["long"].model_copy(
            update={
                "rest_curvature_per_m": random.uniform(0.0, 90.0),
                "rest_curvature_decay_mm": 400.0,
                "eibm_ratio": random.uniform(0.5, 2.0),
            }
        )
        arc = world.arc.model_copy(update={"radius_mm": random.uniform(12.0, 30.0)})
        made = world.model_copy(update={"configurations": {"long": long}, "arc": arc})
        session = session_of(made, 0)
        if len(session.conditions) >= LEAST_REACHED and (
            LEAST_DEG <= _turn_deg(made, session) <= MOST_DEG
        ):
            return made


def session_of(world: WorldSettings, seed: int) -> ReducedSession:
    """Return five positions at three voltages."""
    reach_m = 0.8e-3 * world.arc.radius_mm
    places = np.linspace(0.0, reach_m, POSITIONS).round(4).tolist()
    return reduced_session(world, seed, configurations=("long",), positions_m=places)


def _turn_deg(world: WorldSettings, session: ReducedSession) -> float:
    """Return by how much the free sheet turns, at the voltage where it does most."""
    length_m = 1e-3 * world.configurations["long"].free_length_mm
    s_m = np.linspace(0.0, length_m, 201)
    rest = float(np.mean(world.configurations["long"].rest_curvature(s_m)))
    bends = [rest + moment / session.B_Nm2["long"] for moment in session.mean_eibm_Nm.values()]
    return float(np.degrees(max(map(abs, bends)) * length_m))


def fitted(session: ReducedSession, world: WorldSettings) -> tuple[str, bool]:
    """Return what the fit says, and whether it is right."""
    try:
        made = fit(measurements(session, world), FitOptions())
    except ModelError as error:
        return str(error), False
    one, off_m = made.configurations["long"], made.rmse["varying"].curve_m
    errors = [one.B.value / session.B_Nm2["long"] - 1.0, *_of_eibm(one.eibm, session)]
    said = ", ".join(f"{100 * error:+.1f} %" for error in errors)
    right = max(map(abs, errors)) < NEAR and off_m < CURVE_M
    return f"B and EIBMs {said}, curves {1e3 * off_m:.2f} mm{'' if right else ' (wrong)'}", right


def _of_eibm(found: Mapping[float, Parameter], session: ReducedSession) -> Iterator[float]:
    for volts, parameter in found.items():
        yield parameter.value / session.mean_eibm_Nm["long", volts] - 1.0


if __name__ == "__main__":
    main()

"""Tables of one sheet whose EIBM falls along it, weak to strong: whether `diagnose` says so.

    python -m benchmarks.falling_eibm [SHEETS] [FIRST_SEED]

Sheets are those of `sim_hardware`, a chain of rigid links that shares no code with the model.
Strength (Me/B at the clamp, 8 to 150 per m), the length over which the EIBM falls (5 to 40 mm) and
how it falls, the sheet's length and k0, and the noise of curves (5 to 100 um) are drawn at random.
Seven positions of one sheet, three voltages, means alone: nothing else is known of the sheet.
"""

from __future__ import annotations

import argparse
from collections import Counter

import numpy as np

from benchmarks.interval_coverage import measurements
from model.discrepancy import Diagnosis, diagnose
from sim_hardware.world import WorldSettings, load_world
from sim_hardware.world.curve_noise import CurveErrors
from sim_hardware.world.reduced import reduced_session

NAME = "nonuniform_eibm"
LEAST_REACHED = 12  # of 21 conditions


def main() -> None:
    """Print a line for each sheet, and how often the effect was named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sheets", type=int, nargs="?", default=30)
    parser.add_argument("first_seed", type=int, nargs="?", default=0)
    options = parser.parse_args()
    counted = Counter[str]()
    for seed in range(options.first_seed, options.first_seed + options.sheets):
        what, said = sheet(seed)
        counted[said] += 1
        print(f"{seed}: {what}: {said}", flush=True)
    print(", ".join(f"{count} {said}" for said, count in counted.most_common()))


def sheet(seed: int) -> tuple[str, str]:
    """Return a sheet in words, and what is said of it."""
    random = np.random.default_rng(seed)
    while True:
        world = falling_world(random)
        noise_m = float(np.exp(random.uniform(np.log(5e-6), np.log(1e-4))))
        errors = CurveErrors(white_m=noise_m, smooth_m=2e-6)
        session = reduced_session(world, seed, configurations=("long",), curve_errors=errors)
        if len(session.conditions) >= LEAST_REACHED:
            break
    long, eibm = world.configurations["long"], world.eibm
    what = (
        f"{eibm.curvature_per_m:.0f} per m, {eibm.form} over {eibm.decay_mm:.0f} mm of"
        f" {long.free_length_mm:.0f}, k0 {long.rest_curvature_per_m:.0f} per m, curves"
        f" {1e6 * noise_m:.0f} um, {len(session.conditions)} conditions"
    )
    return what, _said(diagnose(measurements(session, world)))


def falling_world(random: np.random.Generator) -> WorldSettings:
    """Return the shipped world with a long sheet and an EIBM drawn at random."""
    world = load_world()
    eibm = world.eibm.model_copy(
        update={
            "curvature_per_m": float(np.exp(random.uniform(np.log(8.0), np.log(150.0)))),
            "decay_mm": float(np.exp(random.uniform(np.log(5.0), np.log(40.0)))),
            "form": str(random.choice(["exp", "cosh", "line", "root"])),
        }
    )
    long = world.configurations["long"].model_copy(
        update={
            "free_length_mm": float(random.choice([45.0, 50.0, 60.0, 80.0])),
            "rest_curvature_per_m": random.uniform(-15.0, 25.0),
        }
    )
    return world.model_copy(update={"configurations": {"long": long}, "eibm": eibm})


def _said(found: Diagnosis) -> str:
    names = " + ".join(one.name for one in found.effects)
    if names == NAME and found.unknown is None:
        alike = found.effects[0].confusable_with
        return f"named, or one of {len(alike)} others" if alike else "named"
    if found.verdict == "cannot_tell" and not names:
        return "cannot tell"
    if found.unknown is not None:
        return f"{names} and something unknown" if names else "something unknown"
    return names or "nothing"


if __name__ == "__main__":
    main()

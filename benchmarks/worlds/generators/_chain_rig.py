"""What can be wrong of clamp, rolls and load cell in the world `chain`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.worlds.generators._chain_links import Floats
from benchmarks.worlds.generators._chain_plant import SHORT, Course, Load, Plant, only

Change = Callable[[Plant, float], None]


def put(name: str, scale: float = 1.0) -> Change:
    return lambda plant, size: setattr(plant, name, size * scale)


def moved(plant: Plant, size: float) -> None:
    plant.place.append(lambda p, _: p + size * 1e-3)


def screw(plant: Plant, size: float) -> None:
    plant.place.append(lambda p, _: p + size * 1e-3 * float(np.sin(2 * np.pi * p / 0.014)))


def backlash(plant: Plant, size: float) -> None:
    plant.place.append(lambda p, _: p + size * 0.5e-3 * (-1.0) ** round(p / 0.005))


def knocked(plant: Plant, size: float) -> None:
    plant.place.append(lambda p, share: p + size * 1e-3 * (0.2 < share < 0.45))


def felt(more_mN: Callable[[Course, Load, float], Floats]) -> Change:
    """Return a change that adds a force in mN to what the cell shows."""

    def change(plant: Plant, size: float) -> None:
        plant.felt.append(lambda c, load: 1e-3 * more_mN(c, load, size))

    return change


def behind(c: Course, load: Load, size: float) -> Floats:
    """Return what a play of half width `size` in mN takes from the force."""
    force, shown = 1e3 * load.force_N, np.empty(len(load.force_N))
    if c.position_m is None:
        return np.zeros(len(shown))
    at = force[0]
    for i, one in enumerate(force.tolist()):
        at = max(one - size, min(one + size, at))
        shown[i] = at
    return np.asarray(shown - force)


def stuck(c: Course, load: Load, size: float) -> Floats:
    far = c.position_m is not None and c.position_m > 0.0199
    return -size * np.tanh(1e3 * load.force_N / 0.02) * far


def jerked(c: Course, load: Load, size: float) -> Floats:
    """Return what rolls hold back that let go of 3/5 of it once it has grown to `size` in mN."""
    far = c.position_m is not None and c.position_m > 0.0149
    change = 1e3 * (load.force_N - load.force_N[0])
    grown = np.abs(change) / max(abs(size), 1e-9)
    kept = np.where(grown < 1.0, grown, 0.4 + np.mod(grown - 1.0, 0.6))
    return np.asarray(-size * np.sign(change) * kept * far)


def dragged(c: Course, load: Load, size: float) -> Floats:
    way = np.where(c.volts < 0.0, -1.0, 1.0)
    return np.asarray(-size * way * np.sin(load.lean_rad))


def wet(c: Course, load: Load, size: float) -> Floats:
    return size * np.cos(load.lean_rad) * only(c.sheet, SHORT)


def drying_rolls(c: Course, load: Load, size: float) -> Floats:
    return size * np.cos(load.lean_rad) * (1.0 - 0.5 * c.session)


def turned(_: Course, load: Load, size: float) -> Floats:
    felt = load.normal_N * np.cos(load.lean_rad - size)
    return np.asarray(1e3 * (felt - load.force_N))


def cubic(_: Course, load: Load, size: float) -> Floats:
    return np.asarray(size * (1e3 * load.force_N) ** 2 * np.sign(load.force_N))


def cable(c: Course, _: Load, size: float) -> Floats:
    p = c.position_m or 0.0
    return np.full(len(c.time_s), size * np.cos(2 * np.pi * p / 0.02))


def swinging(c: Course, _: Load, size: float) -> Floats:
    return np.asarray(size * np.sin(5 * np.pi * c.session))

"""What can be otherwise along the sheet of the world `chain`."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._chain_links import Bending, Floats
from benchmarks.worlds.generators._chain_plant import LONG, Plant, only


def _bump(at_m: float, width_m: float, s: Floats) -> Floats:
    return np.asarray(np.exp(-0.5 * ((s - at_m) / width_m) ** 2))


def starved(plant: Plant, size: float) -> None:
    plant.profile.append(lambda _, s: 1.0 / (1.0 + size * s / 0.05))


def patch(plant: Plant, size: float) -> None:
    plant.profile.append(lambda sheet, s: 1.0 + size * only(sheet, LONG) * _bump(0.022, 3e-3, s))


def more_curved(plant: Plant, size: float) -> None:
    plant.rest.append(lambda _, s: np.full(len(s), size))


def kinked(plant: Plant, size: float) -> None:
    plant.rest.append(lambda sheet, s: size * only(sheet, LONG) * _bump(0.03, 1.5e-3, s))


def graded(plant: Plant, size: float) -> None:
    plant.softness.append(lambda sheet, s: (1 + size / 2) / (1 + size * s / sheet.free_m))


def creased(plant: Plant, size: float) -> None:
    plant.softness.append(lambda sheet, s: 1.0 + size * only(sheet, LONG) * _bump(0.018, 1e-3, s))


def squeezed(plant: Plant, size: float) -> None:
    plant.even.append(lambda _, s: size * np.exp(-s / 6e-3))


def stiffening(plant: Plant, size: float) -> None:
    plant.bending = _softer(size)


def _softer(size: float) -> Bending:
    """Return u of v = moment over B, for a strip that stiffens by `size` at 10 per m."""
    return lambda v: v / (1.0 + 4.0 * size * (v / 10.0) ** 2) ** 0.25


def one_sided(plant: Plant, size: float) -> None:
    """The face that is pulled where the strip bends towards +y gives way less than the other."""
    plant.bending = lambda v: np.asarray(v / (1.0 + 0.5 * size * (1.0 + np.tanh(v / 6.0))))

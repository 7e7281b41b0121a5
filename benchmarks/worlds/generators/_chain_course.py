"""What can change in time in the world `chain`."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._chain_links import Floats
from benchmarks.worlds.generators._chain_plant import Course, Plant, lag


def drying(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: np.exp(size * (c.session - 0.5)))


def wearing(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 + size * (c.session - 0.5)))


def wearing_late(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 + size * (c.session**3 - 0.25)))


def yielding(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: ((c.time_s + 0.3) / 5.0) ** -size)


def slow(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda _, u: lag(u, size))


def relaxing(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 - size * -np.expm1(-((c.since_s / 0.6) ** 0.7))))


def waking(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 - size / (1.0 + np.maximum(c.pulse, 0.0)) ** 1.5))


def ringing(plant: Plant, size: float) -> None:
    def rung(c: Course, u: Floats) -> Floats:
        wave = np.exp(-c.since_s / 0.25) * np.sin(2 * np.pi * c.since_s / 0.17)
        return np.asarray(u * (1.0 + size * wave))

    plant.amplitude.append(rung)


def cracking(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * np.where(c.session > 0.62, 1.0 - size, 1.0))


def breathing(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 + size * np.sin(5 * np.pi * c.session)))


def stuttering(plant: Plant, size: float) -> None:
    plant.amplitude.append(lambda c, u: u * (1.0 + size * np.where(c.pulse % 4 < 2, 0.5, -0.5)))


def charged_stiff(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: 1.0 + size * np.abs(c.risen()))


def stiff_anode(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: 1.0 + size * np.maximum(c.risen(), 0.0))


def wetter_outwards(plant: Plant, size: float) -> None:
    plant.stiffness.append(lambda c: 1.0 - size * ((c.position_m or 0.0) / 0.03) ** 0.7)

"""What can be wrong of the camera of the world `chain`."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._chain_links import Floats
from benchmarks.worlds.generators._chain_plant import Course, Plant


def larger(plant: Plant, size: float) -> None:
    plant.seen.append(lambda _, xy: (1.0 + size) * xy)


def tilted(plant: Plant, size: float) -> None:
    plant.seen.append(lambda _, xy: xy / (1.0 - size * xy[..., :1] / 0.05))


def barrel(plant: Plant, size: float) -> None:
    """The lens's axis is 25 mm from the clamp."""
    centre = np.array([0.025, 0.0])

    def pictured(_: Course, xy: Floats) -> Floats:
        away = xy - centre
        return centre + away * (1.0 + size * np.sum(away**2, axis=-1, keepdims=True) / 0.025**2)

    plant.seen.append(pictured)


def outer_face(plant: Plant, size: float) -> None:
    def pictured(_: Course, xy: Floats) -> Floats:
        along = np.gradient(xy, axis=-2)
        along /= np.linalg.norm(along, axis=-1, keepdims=True)
        bright = np.sign(xy[..., -1:, 1:])  # the face that is stretched
        return xy + 1e-3 * size * bright * np.stack([-along[..., 1], along[..., 0]], axis=-1)

    plant.seen.append(pictured)


def sinking(plant: Plant, size: float) -> None:
    def pictured(c: Course, xy: Floats) -> Floats:
        return xy + np.array([0.0, 1e-3 * size * float(c.session[0])])

    plant.seen.append(pictured)

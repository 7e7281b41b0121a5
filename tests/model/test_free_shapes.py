"""Free shapes that share their places are those worked out alone."""

from __future__ import annotations

import numpy as np

from model.mechanics.field import Field
from model.mechanics.free_shape import SharedFreeShapes, free_shape

BREAKS = np.array([0.0, 0.02, 0.05])
PLACES = np.linspace(0.0, 0.06, 33)  # beyond the sheet's end, too
KAPPA = np.array([[20.0, -7.0, 3.0], [30.0, 5.0, -2.0]])


def test_shapes_at_the_same_places_are_those_of_each_alone():
    shapes = SharedFreeShapes(BREAKS, 3, PLACES)
    for factor in (1.0, -2.0):
        together, alone = (
            shapes.shape(factor * KAPPA),
            free_shape(Field(BREAKS, factor * KAPPA), PLACES),
        )
        for one, other in zip(together, alone, strict=True):
            np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-15)


def test_their_answers_are_differences():
    shapes, directions = SharedFreeShapes(BREAKS, 3, PLACES), np.eye(6).reshape(6, 2, 3)
    found = shapes.answers(KAPPA, directions)
    for number, direction in enumerate(directions):
        h = 1e-3
        high, low = (shapes.shape(KAPPA + sign * h * direction) for sign in (1.0, -1.0))
        for answer, up, down in zip(found, high, low, strict=False):
            np.testing.assert_allclose(answer[number], (up - down) / (2.0 * h), atol=1e-10)

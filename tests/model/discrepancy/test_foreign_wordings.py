"""Effects in the words of others, between the values that the catalogue tries, keep their name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.worlds.cases import PAPER
from benchmarks.worlds.registry import world
from benchmarks.worlds.session.effects import Array, Image, Load
from model.discrepancy import Diagnosis, diagnose
from tests.fits_unchecked import fits_unchecked


def tilted(image: Image, size: float) -> tuple[Array, Array]:
    """It was a wrong scale, or a perspective beside an error of the arc."""
    across = image.x_m * np.cos(np.radians(22.0)) + image.y_m * np.sin(np.radians(22.0))
    share = 1.0 / (1.0 - size * across / 50e-3)
    return image.x_m * share, image.y_m * share


def oblong(image: Image, size: float) -> tuple[Array, Array]:
    """The ruler lay along the diagonal; a wrong scale beside an error of the arc, it was."""
    return image.x_m * (1.0 + size), image.y_m * (1.0 - size)


def tared(load: Load, size_mN: float) -> Array:
    """The cell was set to zero a quarter into the session; it was something unknown."""
    return np.asarray(load.force_N + size_mN * 1e-3 * (load.samples.tau - 0.25))


def diagnosed(name: str, size: float, **acts: Callable[..., Any]) -> Diagnosis:
    """What is found in a session of `elements` whose effect acts like that."""
    one = world("elements")
    other = replace(one, acts={**one.acts, name: replace(one.acts[name], **acts)})
    with fits_unchecked():
        return diagnose(other.measure(PAPER, {name: size}, 5))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "size", "acts"),
    [
        ("camera_perspective", 0.02, {"image": tilted}),
        ("camera_scale", 0.02, {"image": oblong}),
        ("force_drift", 0.4, {"force": tared}),
    ],
)
def test_its_name_stands_alone(name: str, size: float, acts: dict[str, Callable[..., Any]]):
    found = diagnosed(name, size, **acts)
    assert [effect.name for effect in found.effects] == [name]
    assert found.unknown is None
    assert found.effects[0].probability > 0.9

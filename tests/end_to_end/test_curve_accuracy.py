"""From the simulated camera's pictures to the neutral curve, against the world's own shape."""

from __future__ import annotations

import numpy as np
import pytest

from labrig.config import parse_sheet
from labrig.config.templates import template_text
from labrig.vision import Optics, StripGeometry, neutral_curve
from sim_hardware.clock import VirtualClock
from sim_hardware.world import World, load_world

LIMIT_M = 0.1e-3
GAIN = 10.0


def distance_m(points: np.ndarray, polyline: np.ndarray) -> np.ndarray:
    """Distance of each point from a polyline."""
    start, step = polyline[:-1], np.diff(polyline, axis=0)
    along = ((points[:, None] - start) * step).sum(2) / (step**2).sum(1)
    foot = start + np.clip(along, 0.0, 1.0)[..., None] * step
    return np.asarray(np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1))


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "configuration", ["long", pytest.param("short", marks=pytest.mark.thorough)]
)
@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(s, marks=pytest.mark.thorough) for s in (2, 3))]
)
def test_curves_of_mean_images_are_right_to_a_tenth_of_a_millimetre(
    configuration: str, seed: int
) -> None:
    optics = Optics.from_json(template_text("optics.json")).model_copy(update={"bits": 16})
    sheet = parse_sheet(template_text("sheet.toml"), "sheet.toml")[configuration]
    strip = StripGeometry(
        free_length_m=sheet.free_length_m,
        elongation_m=sheet.elongation_m,
        thickness_m=sheet.thickness_m,
    )
    clock = VirtualClock()
    world = World(load_world(None, seed), clock)
    world.mount(configuration)
    number = 0
    for position_m in (0.0, 0.01, 0.02, 0.03, None):
        world.place(position_m)
        for voltage_V in (0.0, 2.0, -2.0):
            world.write("PCI6703", "ao0", voltage_V / GAIN, clock.now())
            clock.sleep_until(clock.now() + 0.5)
            images = []
            for _ in range(10):
                number += 1
                images.append(world.image(clock.now(), number).astype(float))
            mean = np.rint(256 * np.mean(images, axis=0)).astype(np.uint16)
            found = neutral_curve(mean, optics, strip)
            assert found.ok, found.why
            points = np.column_stack([found.x_m, found.y_m])
            rms_m = float(np.sqrt(np.mean(distance_m(points, world.true_shape(clock.now())) ** 2)))
            assert rms_m < LIMIT_M
            assert found.s_m[-1] == pytest.approx(sheet.free_length_m + sheet.elongation_m)

"""From the simulated camera's pictures to the neutral curve, against the world's own shape."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.polynomial import legendre
from scipy.interpolate import CubicSpline

from labrig.config import parse_sheet
from labrig.config.templates import template_text
from labrig.vision import Optics, StripGeometry, neutral_curve
from labrig.vision.uncertainty.parts import SECTION_SIGMA_PX
from sim_hardware.clock import VirtualClock
from sim_hardware.world import World, load_world

LIMIT_M = 0.1e-3
GAIN = 10.0
IMAGES = 10


def distance_m(points: np.ndarray, polyline: np.ndarray) -> np.ndarray:
    """Distance of each point from a polyline."""
    start, step = polyline[:-1], np.diff(polyline, axis=0)
    along = ((points[:, None] - start) * step).sum(2) / (step**2).sum(1)
    foot = start + np.clip(along, 0.0, 1.0)[..., None] * step
    return np.asarray(np.linalg.norm(points[:, None] - foot, axis=2).min(axis=1))


def offsets_m(x_m: np.ndarray, y_m: np.ndarray, shape: np.ndarray) -> np.ndarray:
    """Distance of each point to the left of a smooth curve through these places."""
    steps = np.hypot(*np.diff(shape, axis=0).T)
    smooth = CubicSpline(np.append(0.0, np.cumsum(steps)), shape)
    s = np.linspace(0.0, steps.sum(), 8001)
    line, along = smooth(s), smooth(s, 1)
    nearest = np.argmin(np.hypot(x_m[:, None] - line[:, 0], y_m[:, None] - line[:, 1]), axis=1)
    gap = np.column_stack([x_m, y_m]) - line[nearest]
    t = along[nearest] / np.hypot(*along[nearest].T)[:, None]
    return np.asarray(t[:, 0] * gap[:, 1] - t[:, 1] * gap[:, 0])


def known(configuration: str) -> tuple[Optics, StripGeometry]:
    """What `labrig init` writes of camera and sheet, for mean images."""
    optics = Optics.from_json(template_text("optics.json")).model_copy(update={"bits": 16})
    sheet = parse_sheet(template_text("sheet.toml"), "sheet.toml")[configuration]
    strip = StripGeometry(
        free_length_m=sheet.free_length_m,
        elongation_m=sheet.elongation_m,
        thickness_m=sheet.thickness_m,
    )
    return optics, strip


def mean_image(world: World, now_s: float, first: int = 0) -> np.ndarray:
    """The mean of ten images, as 16 bit."""
    images = [world.image(now_s, first + 1 + n).astype(float) for n in range(IMAGES)]
    return np.rint(256 * np.mean(images, axis=0)).astype(np.uint16)


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
    optics, strip = known(configuration)
    clock = VirtualClock()
    world = World(load_world(None, seed), clock)
    world.mount(configuration)
    number = 0
    for position_m in (0.0, 0.01, 0.02, 0.03, None):
        world.place(position_m)
        for voltage_V in (0.0, 2.0, -2.0):
            world.write("PCI6703", "ao0", voltage_V / GAIN, clock.now())
            clock.sleep_until(clock.now() + 0.5)
            found = neutral_curve(mean_image(world, clock.now(), number), optics, strip)
            number += IMAGES
            assert found.ok, found.why
            points = np.column_stack([found.x_m, found.y_m])
            rms_m = float(np.sqrt(np.mean(distance_m(points, world.true_shape(clock.now())) ** 2)))
            assert rms_m < LIMIT_M
            assert found.s_m[-1] == pytest.approx(strip.length_m)


@pytest.mark.slow
@pytest.mark.parametrize("position_m", [0.0, 0.02])
def test_the_curve_of_an_elongation_that_gives_way_is_right_and_says_so(
    position_m: float, tmp_path: Path
) -> None:
    """It was taken as straight, and no curve of such a sheet was found."""
    settings = tmp_path / "world.toml"
    settings.write_text("[configurations.short]\nelongation_give = 0.3\n")
    optics, strip = known("short")
    clock = VirtualClock()
    world = World(load_world(settings, 3), clock)
    world.mount("short")
    world.place(position_m)
    world.write("PCI6703", "ao0", 2.0 / GAIN, clock.now())
    clock.sleep_until(0.5)
    found = neutral_curve(mean_image(world, clock.now()), optics, strip)
    assert found.ok, found.why
    assert any("no straight elongation fits" in text for text in found.warnings)
    away_m = distance_m(np.column_stack([found.x_m, found.y_m]), world.true_shape(clock.now()))
    assert np.all(away_m < np.maximum(4 * found.sigma_m, 0.01e-3))
    assert float(np.sqrt(np.mean(away_m**2))) < 0.02e-3


@pytest.mark.slow
def test_noiseless_images_show_the_modes_of_a_curve_as_well_as_is_stated(tmp_path: Path) -> None:
    """A diagnosis takes each mode of a curve to be known so well, however many images there are."""
    settings = tmp_path / "world.toml"
    settings.write_text(
        "[camera.noise]\nelectrons_per_level = 1e4\nread_levels = 0.3\n"
        "[camera.light]\nvignetting = 0.0\ngradient = [0.0, 0.0]\nunevenness = 0.0\n"
    )
    clock = VirtualClock()
    world = World(load_world(settings, 11), clock)
    _, strip = known("long")
    calibration = world.settings.camera.calibration() | {"bits": 16}
    optics = Optics.from_json(json.dumps(calibration))
    world.mount("long")
    modes_px = []
    for position_m in (0.0, 0.015, 0.03):
        world.place(position_m)
        for voltage_V in (0.0, 2.0, -2.0):
            world.write("PCI6703", "ao0", voltage_V / GAIN, clock.now())
            clock.sleep_until(clock.now() + 0.5)
            found = neutral_curve(mean_image(world, clock.now()), optics, strip)
            true = world.true_shape(clock.now())
            off_px = offsets_m(found.x_m, found.y_m, true) * optics.px_per_m
            t = np.linspace(-1.0, 1.0, len(off_px))
            modes_px.append(legendre.legfit(t, off_px, 9))
    rms_px = float(np.sqrt(np.mean(np.square(modes_px))))
    assert rms_px < SECTION_SIGMA_PX
    assert rms_px > 0.1 * SECTION_SIGMA_PX

"""Sheets and measurements made with the base model itself: what a fit must find is known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from model import (
    Along,
    Condition,
    ConfiguredSheet,
    Curve,
    Measurements,
    Parameter,
    Reading,
    SheetGeometry,
    SheetModel,
    predict,
)
from model.sheet.prediction import predict_free

REFERENCE = Path(__file__).parents[1] / "data" / "reference"
LONG_B, SHORT_B = 1.27e-6, 8.5e-7


def exact(value: float, unit: str) -> Parameter:
    return Parameter(value=value, sigma=0.0, unit=unit)


def geometry(name: str, k0: float | None = None) -> SheetGeometry:
    long = name == "long"
    s = np.linspace(0.0, 0.05, 6)
    rest = (s, 24.0 * np.exp(-s / 0.04)) if long else (np.zeros(1), np.array([28.0]))
    if k0 is not None:
        rest = (np.zeros(1), np.array([k0]))
    return SheetGeometry(
        configuration=name,
        free_length_m=0.05 if long else 0.0045,
        width_m=0.011,
        thickness_m=0.21e-3,
        elongation_m=0.0 if long else 0.04,
        arc_radius_m=0.04,
        arc_origin_rad=0.0,
        initial_curvature=rest,
    )


@pytest.fixture(scope="session")
def truth() -> SheetModel:
    """Both sheets with constant EIBM."""
    sheets = {}
    for name, B, curvature in (("long", LONG_B, 25.0), ("short", SHORT_B, 80.0)):
        sheet = geometry(name)
        assert sheet.initial_curvature is not None
        rest = Along(*sheet.initial_curvature, np.zeros(len(sheet.initial_curvature[0])), "1/m")
        eibm = {
            2.0: Along.constant(exact(B * curvature, "N m")),
            -2.0: Along.constant(exact(-0.8 * B * curvature, "N m")),
        }
        sheets[name] = ConfiguredSheet(sheet, exact(B, "N m^2"), rest, eibm)
    return SheetModel(sheets=sheets)


MakeMeasurements = Callable[..., Measurements]


@pytest.fixture(scope="session")
def measure(truth: SheetModel) -> MakeMeasurements:
    """Measurements of `truth`: noise of forces and curves, B and EIBM scatter between set-ups."""

    def make(
        seed: int = 0,
        names: tuple[str, ...] = ("long", "short"),
        positions_mm: tuple[float, ...] = (0, 5, 10, 15, 20, 25, 30),
        force_N: float = 5e-5,
        curve_m: float = 1e-5,
        scatter: float = 0.01,
        model: SheetModel | None = None,
        curves: bool = True,
        free: bool = False,
    ) -> Measurements:
        random = np.random.default_rng(seed)
        model = model or truth
        conditions = []
        for name in names:
            for position in positions_mm:
                z = scatter * random.standard_normal(2)
                shaken = _shaken(model, name, 1.0 + z[0], 1.0 + z[1])
                for voltage in (0.0, 2.0, -2.0):
                    p = predict(shaken, name, position * 1e-3, voltage)
                    assert p.reachable, p.why
                    forces = p.F_N + force_N * random.standard_normal(10)
                    kind = "kept" if voltage else "zero"
                    readings = tuple(
                        Reading(index=i, kind=kind, force_N=float(f)) for i, f in enumerate(forces)
                    )
                    curve = noisy(p.s_m, p.x_m, p.y_m, curve_m, random) if curves else None
                    conditions.append(
                        Condition(
                            configuration=name,
                            position_m=position * 1e-3,
                            voltage_V=voltage,
                            readings=readings,
                            curve=curve,
                        )
                    )
            for voltage in (0.0, 2.0, -2.0) if free else ():
                curve = noisy(*predict_free(model, name, voltage), curve_m, random)
                conditions.append(
                    Condition(
                        configuration=name,
                        position_m=None,
                        voltage_V=voltage,
                        readings=(),
                        curve=curve,
                    )
                )
        return Measurements(
            sheets={n: model.sheets[n].sheet for n in names},
            conditions=tuple(conditions),
            source="made",
        )

    return make


def noisy(s, x, y, size, random) -> Curve:
    """Errors along the normal, correlated over 5 mm."""
    phi = np.arctan2(np.gradient(y), np.gradient(x))
    bumps = np.exp(-0.5 * ((s[:, None] - np.arange(0.0, s[-1] + 0.005, 0.005)) / 0.005) ** 2)
    off = (
        size
        * (bumps @ random.standard_normal(bumps.shape[1]) + random.standard_normal(len(s)))
        / 1.6
    )
    return Curve(s_m=s, x_m=x - off * np.sin(phi), y_m=y + off * np.cos(phi))


def _shaken(model: SheetModel, name: str, B: float, eibm: float) -> SheetModel:
    one = model.sheet(name)
    moved = {v: Along(a.s_m, a.values * eibm, a.sigma, a.unit) for v, a in one.eibm.items()}
    stiff = exact(one.B.value * B, "N m^2")
    return SheetModel(sheets={name: ConfiguredSheet(one.sheet, stiff, one.rest, moved)})

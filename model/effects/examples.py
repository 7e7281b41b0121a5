"""Made-up problems and solutions of the right kind, to try an effect on.

A sheet of 50 mm with an elongation: held at 5 and 25 mm at 0, +2 and -2 V, and free at +2 V.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from model.effects.interface import (
    AcquisitionTimes,
    BeamProblem,
    ContactSolution,
    ImagePoints,
    LoadCellInput,
)
from model.measurements import FloatArray, SheetGeometry

NODES, READINGS, DISCARDED = 14, 32, 2
B_NM2, RADIUS_M, LENGTH_M = 1.27e-6, 0.04, 0.05


def example_sheet() -> SheetGeometry:
    """The sheet."""
    rest = (np.array([0.0]), np.array([20.0]))
    return SheetGeometry("long", LENGTH_M, 0.011, 0.21e-3, 0.02, RADIUS_M, 0.0, rest)


def example_beam(*, touched: bool = True) -> tuple[BeamProblem, ContactSolution]:
    """Seven conditions and a solution; not `touched`: nothing touches the sheet in any of them."""
    voltage = np.array([0.0, 2.0, -2.0, 0.0, 2.0, -2.0, 2.0])
    stated = np.array([0.005, 0.005, 0.005, 0.025, 0.025, 0.025, np.nan])
    normal = np.array([1e-3, 3e-3, -2e-3, -1e-3, 1e-3, -3e-3, np.nan])
    if not touched:
        stated, normal = np.full(7, np.nan), np.full(7, np.nan)
    held_at = np.isfinite(normal)
    s = LENGTH_M * 0.5 * (1.0 + np.polynomial.legendre.leggauss(NODES)[0])
    curvature = np.array([20.0, 30.0, 8.0, 25.0, 35.0, 12.0, 45.0])[:, None] * np.ones(NODES)
    phi, end_phi = curvature * s, curvature[:, 0] * LENGTH_M
    x, y = np.sin(phi) / curvature, (1.0 - np.cos(phi)) / curvature
    beta, s_hat = stated / RADIUS_M, np.array([0.041, 0.043, 0.0405, 0.042, 0.045, 0.041, np.nan])
    phi_hat = curvature[:, 0] * s_hat
    gamma = np.where(held_at, phi_hat - beta, np.nan)
    dx, dy = RADIUS_M * np.cos(beta)[:, None] - x, RADIUS_M * np.sin(beta)[:, None] - y
    cos, sin = np.cos(phi_hat)[:, None], np.sin(phi_hat)[:, None]
    before = s < s_hat[:, None]
    zero, flat = np.zeros(7), np.zeros((7, NODES))
    beam = BeamProblem(
        example_sheet(), s, voltage, stated, np.array([1.0, 1, 1, -1, -1, -1, 1]),
        np.full(7, B_NM2), flat.copy(), np.outer(15.0 * voltage, np.ones(NODES)), flat.copy(),
        np.ones((7, NODES)), zero.copy(), zero.copy(), zero.copy(), zero.copy(),
        LENGTH_M * 0.5 * np.polynomial.legendre.leggauss(NODES)[1], *example_readings(voltage),
    )  # fmt: skip
    contact = ContactSolution(
        normal * np.cos(gamma), normal, gamma, np.where(held_at, s_hat, np.nan),
        np.where(before, dx * cos + dy * sin, 0.0), np.where(before, dy * cos - dx * sin, 0.0),
        x, y, phi, curvature, end_phi,
    )  # fmt: skip
    return beam, contact


def example_clock() -> AcquisitionTimes:
    """A run in the middle of a session: ten readings at 0 V, then 22 pulses of alternating sign."""
    index = np.arange(READINGS, dtype=float)
    pulse = np.maximum(index - 10.0, -1.0)
    voltage = np.where(pulse < 0.0, 0.0, np.where(pulse % 2 == 0.0, 2.0, -2.0))
    run_s, driven_s = 0.6 * index + 0.5, 0.6 * np.maximum(pulse, 0.0)
    opposite = np.where(pulse > 0.0, -1.0, np.where(pulse == 0.0, 0.0, 1.0))
    session = 0.5 + 0.05 * index / READINGS
    return AcquisitionTimes(
        voltage, np.full(READINGS, 0.5), pulse, run_s, session, run_s + 5.0, driven_s, opposite
    )


def example_readings(
    voltage_V: FloatArray,
) -> tuple[AcquisitionTimes, npt.NDArray[np.int64], FloatArray]:
    """The readings of conditions, of which condition each is, and its share in the mean.

    The first two pulses are in no mean.
    """
    clock = example_clock()
    use = [clock.voltage_V == volts for volts in voltage_V]
    of = np.repeat(np.arange(len(use)), [int(np.sum(u)) for u in use])
    every = AcquisitionTimes.joined([clock.of(u) for u in use])
    counts = (every.pulse < 0.0) | (every.pulse >= DISCARDED)
    return every, of, counts / np.bincount(of, counts)[of]


def example_pulse() -> AcquisitionTimes:
    """Times within a pulse of the same run."""
    t = np.linspace(0.02, 0.58, 8)
    one = np.ones_like(t)
    return AcquisitionTimes(2.0 * one, t, 6.0 * one, 9.6 + t, 0.51 * one, 14.6 + t, 3.6 + t, -one)


def example_weighed(*, touched: bool = True) -> LoadCellInput:
    """The readings of the same run at 25 mm."""
    volts = example_clock().voltage_V
    gamma = 0.3 + 0.1 * volts
    normal = (-1e-3 + 1e-3 * volts) * float(touched)
    return LoadCellInput(
        normal * np.cos(gamma), normal, gamma, np.full(READINGS, 0.025 if touched else np.nan),
        example_clock().session, np.full(READINGS, float(touched)), example_clock().wetted_s,
    )  # fmt: skip


def example_points() -> ImagePoints:
    """Two arcs of the sheet's length."""
    s = np.linspace(0.0, LENGTH_M, 21)
    k = np.array([[20.0], [40.0]])
    return ImagePoints(np.sin(k * s) / k, (1.0 - np.cos(k * s)) / k, LENGTH_M)

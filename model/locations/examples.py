"""Made-up problems and solutions of the right kind, to try effects and locations on.

A sheet of 50 mm with an elongation: held at 5 and 25 mm at 0, +2 and -2 V, and free at +2 V.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from model.locations.contract import Linearised
from model.locations.quantities import (
    AcquisitionTimes,
    BeamProblem,
    ContactSolution,
    ImagePoints,
    LoadCellInput,
    Perturbation,
)
from model.measurements import FloatArray, RigScale, SheetGeometry
from model.measurements.pulse_train import DISCARDED, PULSE_S, SAMPLE_S

NODES, READINGS = 14, 32
B_NM2, RADIUS_M, LENGTH_M = 1.27e-6, 0.04, 0.05


def example_sheet() -> SheetGeometry:
    """Return the sheet."""
    rest = (np.array([0.0]), np.array([20.0]))
    return SheetGeometry(
        configuration="long", free_length_m=LENGTH_M, width_m=0.011, thickness_m=0.21e-3,
        elongation_m=0.02, arc_radius_m=RADIUS_M, arc_origin_rad=0.0, initial_curvature=rest,
    )  # fmt: skip


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
    clock, reading_of, share = example_readings(voltage)
    beam = BeamProblem(
        sheet=example_sheet(), s_m=s, voltage_V=voltage, stated_m=stated,
        up=np.array([1.0, 1, 1, -1, -1, -1, 1]), stiffness=np.full(7, B_NM2), rest=flat.copy(),
        eibm=np.outer(15.0 * voltage, np.ones(NODES)), bend=flat.copy(), soft=np.ones((7, NODES)),
        elongation_soft=zero.copy(), shift_m=zero.copy(), tilt_rad=zero.copy(),
        offset_m=zero.copy(), reach_m=zero.copy(),
        piece_m=LENGTH_M * 0.5 * np.polynomial.legendre.leggauss(NODES)[1],
        clock=clock, reading_of=reading_of, share=share,
        session_number=np.array([1.0, 1, 1, 2, 2, 2, 2]),
    )  # fmt: skip
    contact = ContactSolution(
        force_N=normal * np.cos(gamma), normal_N=normal, gamma_rad=gamma,
        s_hat_m=np.where(held_at, s_hat, np.nan), lever=np.where(before, dx * cos + dy * sin, 0.0),
        offset=np.where(before, dy * cos - dx * sin, 0.0), x_m=x, y_m=y, phi_rad=phi,
        curvature=curvature, end_phi_rad=end_phi, at_rest=np.full(NODES, 20.0),
    )  # fmt: skip
    return beam, contact


def example_clock() -> AcquisitionTimes:
    """Return a run amid a session: ten readings at 0 V, 22 pulses of alternating sign."""
    index = np.arange(READINGS, dtype=float)
    pulse = np.maximum(index - 10.0, -1.0)
    voltage = np.where(pulse < 0.0, 0.0, np.where(pulse % 2 == 0.0, 2.0, -2.0))
    run_s, driven_s = PULSE_S * index + SAMPLE_S, PULSE_S * np.maximum(pulse, 0.0)
    opposite = np.where(pulse > 0.0, -1.0, np.where(pulse == 0.0, 0.0, 1.0))
    session = 0.5 + 0.05 * index / READINGS
    return AcquisitionTimes(
        voltage_V=voltage,
        pulse_s=np.full(READINGS, 0.5),
        pulse=pulse,
        run_s=run_s,
        session=session,
        wetted_s=run_s + 5.0,
        driven_s=driven_s,
        opposite=opposite,
    )


def example_readings(
    voltage_V: FloatArray,
) -> tuple[AcquisitionTimes, npt.NDArray[np.int64], FloatArray]:
    """Return the readings of conditions, of which condition each is, and its share in the mean.

    The first two pulses are in no mean.
    """
    clock = example_clock()
    use = [clock.voltage_V == volts for volts in voltage_V]
    of = np.repeat(np.arange(len(use)), [int(np.sum(u)) for u in use])
    every = AcquisitionTimes.joined([clock.of(u) for u in use])
    counts = (every.pulse < 0.0) | (every.pulse >= DISCARDED)
    return every, of, counts / np.bincount(of, counts)[of]


def example_pulse() -> AcquisitionTimes:
    """Return times within a pulse of the same run."""
    t = np.linspace(0.02, 0.58, 8)
    one = np.ones_like(t)
    return AcquisitionTimes(
        voltage_V=2.0 * one,
        pulse_s=t,
        pulse=6.0 * one,
        run_s=9.6 + t,
        session=0.51 * one,
        wetted_s=14.6 + t,
        driven_s=3.6 + t,
        opposite=-one,
    )


def example_weighed(*, touched: bool = True) -> LoadCellInput:
    """Return the readings of the same run at 25 mm."""
    volts = example_clock().voltage_V
    gamma = 0.3 + 0.1 * volts
    normal = (-1e-3 + 1e-3 * volts) * float(touched)
    return LoadCellInput(
        force_N=normal * np.cos(gamma), normal_N=normal, gamma_rad=gamma,
        position_m=np.full(READINGS, 0.025 if touched else np.nan), voltage_V=volts,
        session=example_clock().session, touching=np.full(READINGS, float(touched)),
        wetted_s=example_clock().wetted_s,
        session_number=np.where(np.arange(READINGS) < READINGS // 2, 1.0, 2.0),
    )  # fmt: skip


def example_points() -> ImagePoints:
    """Return two arcs of the sheet's length."""
    s = np.linspace(0.0, LENGTH_M, 21)
    k = np.array([[20.0], [40.0]])
    return ImagePoints(
        s_m=np.broadcast_to(s, (2, len(s))), x_m=np.sin(k * s) / k, y_m=(1.0 - np.cos(k * s)) / k,
        normal_x=-np.sin(k * s), normal_y=np.cos(k * s),
        free_length_m=0.8 * LENGTH_M, contact_m=np.array([[0.9 * LENGTH_M], [np.nan]]),
        pressed_per_m2=np.array([[40.0], [np.nan]]), session_number=np.array([[1.0], [2.0]]),
        voltage_V=np.array([[2.0], [-2.0]]),
    )  # fmt: skip


def example_linearised() -> Linearised:
    """Return the seven conditions as a location sees them, with a made-up sensitivity."""
    beam, contact = example_beam()
    clock, of, pulse = beam.clock, beam.reading_of, example_pulse()
    finite = np.nan_to_num
    weighed = LoadCellInput(
        force_N=finite(contact.force_N)[of], normal_N=finite(contact.normal_N)[of],
        gamma_rad=finite(contact.gamma_rad)[of], position_m=beam.stated_m[of],
        voltage_V=clock.voltage_V, session=clock.session,
        touching=np.isfinite(contact.force_N)[of].astype(float), wetted_s=clock.wetted_s,
    )  # fmt: skip
    points = ImagePoints(
        s_m=np.broadcast_to(beam.s_m, contact.x_m.shape), x_m=contact.x_m, y_m=contact.y_m,
        normal_x=-np.sin(contact.phi_rad), normal_y=np.cos(contact.phi_rad),
        voltage_V=beam.voltage_V[:, None],
    )  # fmt: skip

    def change(other: BeamProblem) -> FloatArray:
        along = [getattr(other, n) - getattr(beam, n) for n in ("rest", "eibm", "bend", "soft")]
        names = ("shift_m", "tilt_rad", "offset_m", "reach_m", "elongation_soft", "stiffness")
        return np.hstack(
            [*along, *((getattr(other, n) - getattr(beam, n))[:, None] for n in names)]
        )

    def nothing() -> Perturbation:
        n, b = len(of), len(pulse.pulse_s)
        return Perturbation(
            beam=np.zeros_like(change(beam)), eibm=np.zeros(n), stiffness=np.zeros(n),
            force_N=np.zeros(n), bin_eibm=np.zeros(b), bin_stiffness=np.zeros(b),
            points_m=np.zeros_like(points.x_m), frame_eibm=np.zeros(n),
        )  # fmt: skip

    return Linearised(
        beam=beam, contact=contact, weighed=weighed, points=points, clock=clock,
        position_m=beam.stated_m[of], reading_of=of, initial_curvature_per_m=np.full(NODES, 20.0),
        force_at_0V_N=np.full(7, 1e-3), measured_at=np.linspace(0.0, 1.0, 7),
        has_curve=np.ones(7, dtype=bool), positions_m=(0.005, 0.025), pictured=((0.0, 1.0),),
        forces_N=(-3e-3, 3e-3),
        bent_per_m=25.0, scale=RigScale(),
        bin_clock=pulse, bin_sample=pulse, bin_mean=np.asarray, configuration="long",
        nothing=nothing,
        change=change,
    )  # fmt: skip

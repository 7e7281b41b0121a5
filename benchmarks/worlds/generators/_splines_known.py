"""Kinds that the catalogue names, in formulas of another laboratory."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.generators._splines_rig import Felt, Rig, Run
from benchmarks.worlds.generators._splines_sheet import A

MM, MN = 1e-3, 1e-3
Hide = Callable[[Rig, float], None]
STICKS_FROM_M = 0.0199


def clamp_angle(rig: Rig, c: float) -> None:
    """Turn the sheet in its clamp."""
    for sheet in rig.sheets.values():
        sheet.clamp_rad += c


def drum(rig: Rig, c: float) -> None:
    """Add curvature that fades towards the end."""
    for sheet in rig.sheets.values():
        length = sheet.length_m
        sheet.rest.append(lambda s, length=length: c * (1.3 - 0.6 * s / length))


def electrode_line(rig: Rig, c: float) -> None:
    """Let the voltage fall along two resistive electrodes with a leak between them."""
    for sheet in rig.sheets.values():
        length = sheet.length_m
        sheet.profile.append(
            lambda s, _sign, length=length: np.cosh(c * (1.0 - s / length)) * c / np.sinh(c)
        )


def askew(rig: Rig, c: float) -> None:
    """Let a share of the weight act along -y."""
    weight = np.sin(np.radians(c)) * 0.045  # N/m
    for sheet in rig.sheets.values():
        length, whole = sheet.length_m, sheet.length_m + sheet.elongation_m

        def load(s: A, length: float = length, whole: float = whole) -> A:
            return -weight * (np.maximum(length - s, 0.0) + 0.5 * (whole - np.maximum(s, length)))

        sheet.dead_load.append(load)


def soft_jaw(rig: Rig, c: float) -> None:
    """Turn the clamp with its moment, ever less as the jaw closes."""
    for sheet in rig.sheets.values():
        sheet.clamp_turns = lambda moment: 0.05 * np.tanh(c * moment / 0.05)


def bending_bar(rig: Rig, c: float) -> None:
    """Let the elongation bend as a cantilever."""
    for sheet in rig.sheets.values():
        sheet.elongation_gives = c


def hardening(rig: Rig, c: float) -> None:
    """Raise the stiffness from one plateau to another as the sheet is bent."""
    for sheet in rig.sheets.values():
        sheet.law = lambda u: u * (1.0 + c * u**2 / (u**2 + 1600.0))


def graded(rig: Rig, c: float) -> None:
    """Let the stiffness grow exponentially along the sheet."""
    for sheet in rig.sheets.values():
        length = sheet.length_m
        sheet.stiffness.append(lambda s, length=length: np.exp(c * (s / length - 0.5)))


def misplaced(rig: Rig, c: float) -> None:
    """Move the load cell along the arc."""
    rig.place.append(lambda p: p + c * MM)


def friction(rig: Rig, c: float) -> None:
    """Rub on the sheet."""
    rig.friction = c


def roll_radius(rig: Rig, c: float) -> None:
    """Touch the sheet beside the arc's point."""
    for sheet in rig.sheets.values():
        sheet.beside_m = c * MM


def pinched(rig: Rig, c: float) -> None:
    """Let the force lag by what holds the sheet, from 20 mm on."""

    def shown(run: Run, felt: Felt) -> A:
        stuck = run.position_m is not None and run.position_m >= STICKS_FROM_M
        return _play(felt.force_N, c * MN) if stuck else felt.force_N

    rig.cell.append(shown)


def _play(force_N: A, half_N: float) -> A:
    """Return a play's output: it follows only when pushed from one side or the other."""
    out, here = np.empty_like(force_N), float(force_N[0])
    for i, force in enumerate(force_N.tolist()):
        here = min(max(here, force - half_N), force + half_N)
        out[i] = here
    return out


def thermal_zero(rig: Rig, c: float) -> None:
    """Let the zero move as heat diffuses in."""
    rig.cell.append(lambda run, felt: felt.force_N + c * MN * np.sqrt(run.share))


def tare(rig: Rig, c: float) -> None:
    """Move the zero."""
    rig.cell.append(lambda _run, felt: felt.force_N + c * MN)


def soft_cell(rig: Rig, c: float) -> None:
    """Let the load cell go along the arc with its force."""
    for sheet in rig.sheets.values():
        sheet.gives_m_per_N = c


def cell_play(rig: Rig, c: float) -> None:
    """Let the load cell hang behind its load."""
    rig.cell.append(lambda _run, felt: _play(felt.force_N, c * MN))


def turned_cell(rig: Rig, c: float) -> None:
    """Turn the axis of the load cell."""
    rig.cell.append(lambda _run, felt: felt.force_N * np.cos(c) - felt.radial_N * np.sin(c))


def meniscus(rig: Rig, c: float) -> None:
    """Pull along the normal of the sheet."""
    rig.cell.append(lambda _run, felt: felt.force_N + c * MN * np.cos(felt.gamma_rad))


def keystone(rig: Rig, c: float) -> None:
    """Project a plane that comes nearer away from the clamp."""
    rig.view.append(lambda x, y: (x / (1.0 - c * x / 0.05), y / (1.0 - c * x / 0.05)))


def wrong_scale(rig: Rig, c: float) -> None:
    """Scale the image about the clamp."""
    rig.view.append(lambda x, y: (x * (1.0 + c), y * (1.0 + c)))


def diffusive_loss(rig: Rig, c: float) -> None:
    """Lose EIBM with the square root of time, in each pulse anew."""

    def left(t: A | float) -> A:
        return np.asarray(1.0 / (1.0 + c * np.sqrt(t)))

    rig.swing.append(lambda run, alpha: alpha * left(run.edge_s) / left(run.sample_s))


def porous_electrode(rig: Rig, c: float) -> None:
    """Approach the settled value as exp(-sqrt(t/tau)), from what the pulse before came to."""

    def lagged(run: Run, alpha: A) -> A:
        out, before = alpha.copy(), 0.0
        for k in range(int(run.pulse[-1]) + 1):
            mine = np.flatnonzero(run.pulse == k)
            lag = np.exp(-np.sqrt(run.edge_s[mine] / c)) if c else 0.0
            out[mine] = alpha[mine] + (before - alpha[mine]) * lag
            before = out[mine[-1]]
        return out

    rig.swing.append(lagged)


def exponential_wear(rig: Rig, c: float) -> None:
    """Let the EIBM grow by e^c over the session."""
    rig.swing.append(lambda run, alpha: alpha * np.exp(c * (run.share - 0.5)))


def first_pulses(rig: Rig, c: float) -> None:
    """Weaken the first pulses."""
    rig.swing.append(
        lambda run, alpha: alpha * (1.0 - c / (1.0 + np.maximum(run.pulse, 0.0)) ** 1.5)
    )


def drying(rig: Rig, c: float) -> None:
    """Let the stiffness grow ever faster over the session."""
    rig.stiffness.append(lambda run: np.exp(c * (run.share**1.5 - 0.4)))


def power_creep(rig: Rig, c: float) -> None:
    """Let the stiffness fall as a power of the time in the run."""
    rig.stiffness.append(lambda run: ((run.time_s + 0.3) / 5.3) ** -c)


def _kind(
    words: str, known_as: str, location: str, typical: float, largest: float, unit: str,
    needs: tuple[str, ...] = (), own_form: bool = False,
) -> HiddenKind:  # fmt: skip
    return HiddenKind(
        words=words, known_as=known_as, locations=(location,), typical=typical, largest=largest,
        unit=unit, needs=needs, own_form=own_form,
    )  # fmt: skip


KINDS: dict[str, tuple[HiddenKind, Hide]] = {
    "clamp_angle": (_kind(
        "The sheet leaves the clamp askew: theta(0) = c.",
        "clamp_angle", "rest_curvature", 0.02, 0.2, "rad", own_form=True), clamp_angle),
    "drum": (_kind(
        "The sheet was kept on a drum: k0 + c (1.3 - 0.6 s/l).",
        "initial_curvature", "rest_curvature", 1.5, 15.0, "1/m"), drum),
    "electrode_line": (_kind(
        "Electrodes form a leaky line: Me = mean x c cosh(c (1 - s/l))/sinh(c), c = l/lambda.",
        "nonuniform_eibm", "eibm", 0.8, 4.0, ""), electrode_line),
    "askew": (_kind(
        "The plane of motion leans by an angle: 45 mN/m x sin c of weight along -y.",
        "gravity", "even_moment", 3.0, 20.0, "degrees"), askew),
    "soft_jaw": (_kind(
        "The jaw of the clamp is soft: it turns by 0.05 rad x tanh(c M/0.05 rad).",
        "clamp_compliance", "compliance", 60.0, 1000.0, "rad/(N m)"), soft_jaw),
    "bending_bar": (_kind(
        "The elongation bends as a cantilever: N a^3 c/(3 B) at the contact, a from its joint.",
        "elongation_flexibility", "compliance", 0.03, 0.5, ""), bending_bar),
    "hardening": (_kind(
        "The sheet stiffens: M + Me = B u (1 + c u^2/(u^2 + (40/m)^2)), u = k - k0.",
        "nonlinear_stiffness", "compliance", 0.15, 0.6, ""), hardening),
    "graded": (_kind(
        "The polymer is denser at one end: B(s) = B exp(c (s/l - 1/2)).",
        "nonuniform_stiffness", "compliance", 0.2, 1.5, ""), graded),
    "misplaced": (_kind(
        "The load cell is farther along the arc by a length.",
        "position_error", "position", 0.5, 4.0, "mm", own_form=True), misplaced),
    "friction": (_kind(
        "The rolls rub: a force c |N| along the sheet, against the way it last slid.",
        "roll_friction", "position", 0.2, 0.5, ""), friction),
    "roll_radius": (_kind(
        "The arc's point lies beside the sheet: r(s_hat) + c n = p_hat.",
        "roll_offset", "position", 0.5, 4.0, "mm", own_form=True), roll_radius),
    "pinched": (_kind(
        "From 20 mm on the rolls pinch the sheet: the force follows with a play of +-c.",
        "roll_sticking", "position", 0.2, 2.0, "mN"), pinched),
    "thermal_zero": (_kind(
        "Heat diffuses into the load cell: F + c sqrt(t/session).",
        "force_drift", "load_cell", 0.1, 2.0, "mN"), thermal_zero),
    "tare": (_kind(
        "The load cell was tared wrongly: F + c.",
        "force_offset", "load_cell", 0.1, 2.0, "mN", own_form=True), tare),
    "soft_cell": (_kind(
        "The load cell gives way: p + c F.",
        "load_cell_compliance", "load_cell", 0.15, 2.0, "mm/mN", own_form=True), soft_cell),
    "cell_play": (_kind(
        "The load cell's thread has a play of +-c, in which it shows no change.",
        "load_cell_hysteresis", "load_cell", 0.08, 1.0, "mN"), cell_play),
    "turned_cell": (_kind(
        "The load cell's axis is turned by c from the arc's tangent.",
        "load_cell_misalignment", "load_cell", 0.1, 0.7, "rad", own_form=True), turned_cell),
    "meniscus": (_kind(
        "A meniscus pulls with c along the sheet's normal: F + c cos gamma.",
        "surface_tension", "load_cell", 0.1, 1.0, "mN"), meniscus),
    "keystone": (_kind(
        "The camera looks at a slant: r seen = r/(1 - c x/50 mm).",
        "camera_perspective", "camera", 0.01, 0.2, ""), keystone),
    "wrong_scale": (_kind(
        "The picture's scale is wrong: r seen = (1 + c) r.",
        "camera_scale", "camera", 0.01, 0.2, "", own_form=True), wrong_scale),
    "diffusive_loss": (_kind(
        "EIBM leaks away in each pulse as 1/(1 + c sqrt(t/1 s)), equal to it when sampled.",
        "back_relaxation", "time", 0.1, 0.5, "", needs=("series",)), diffusive_loss),
    "porous_electrode": (_kind(
        "The double layer of a rough electrode charges as exp(-sqrt(t/c)).",
        "charging_lag", "time", 0.02, 0.3, "s", needs=("series",)), porous_electrode),
    "exponential_wear": (_kind(
        "EIBM changes over the session as exp(c (t/session - 1/2)).",
        "eibm_drift", "time", 0.1, 0.8, ""), exponential_wear),
    "first_pulses": (_kind(
        "In the first pulses k = 0, 1, ... of a run EIBM is less: 1 - c/(1 + k)^1.5.",
        "first_pulse_transient", "time", 0.15, 0.8, ""), first_pulses),
    "drying": (_kind(
        "The sheet dries: B exp(c ((t/session)^1.5 - 0.4)).",
        "stiffness_drift", "time", 0.1, 0.8, ""), drying),
    "power_creep": (_kind(
        "The polymer relaxes: B ((t + 0.3 s)/5.3 s)^-c, t since the run began.",
        "viscoelastic_creep", "time", 0.015, 0.15, ""), power_creep),
}  # fmt: skip

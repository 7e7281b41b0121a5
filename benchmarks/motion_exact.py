"""The moving sheet against every exact or converged motion of tests/data/reference/dynamics.

Each row: the case, how fine the computation was, the largest error, and what is wanted.
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import csv
from collections.abc import Callable, Iterator

import numpy as np

from benchmarks.report import Report, Table
from model.dynamics import (
    UNDRIVEN,
    ContactSetup,
    DynamicBeam,
    Elongation,
    LineModes,
    PrescribedMoment,
    Resolution,
    Simulation,
    Viscoelasticity,
    energy,
    hydrodynamic_function,
    linearise,
    simulate,
)
from model.mechanics.field import Field
from tests.model.dynamics import cases
from tests.model.dynamics.cases import B, L, R, driven, material, plain, table

Row = tuple[str, str, float, float]  # case, how fine, error, wanted
TIP = np.array([L])


def static() -> Iterator[Row]:
    name = "iv_v_vi_contact_constant_kappa_R40mm.csv"
    with (cases.REFERENCE / name).open() as file:
        rows = [{k: float(v) for k, v in r.items() if k != "case"} for r in csv.DictReader(file)]
    near, far = [], []
    for number, row in enumerate(rows):
        length, s_hat = row["l_mm"] * 1e-3, row["shat_mm"] * 1e-3
        rest = Field.constant(row["kappa_star_1_per_mm"] * 1e3, length)
        beam = plain(rest, length_m=length, elongation=Elongation(length_m=1.0))
        setup = ContactSetup(radius_m=R, position_m=row["p_mm"] * 1e-3)

        def error(
            by: Resolution,
            beam: DynamicBeam = beam,
            setup: ContactSetup = setup,
            wanted: float = row["N_R2_over_B"],
        ) -> float:
            found = Simulation(beam, setup, UNDRIVEN, resolution=by).state.x[0]
            return float(abs(found * R**2 / B / wanted - 1.0))

        near.append(error(Resolution(degrees=(10, 3))))
        if s_hat < length:
            off = (-3e-3, -1e-3, 1e-3, 3e-3)[number % 4]
            far.append(error(Resolution(break_m=float(np.clip(s_hat + off, 0.02, 0.97 * length)))))
    yield f"static force, {len(near)} equilibria, relative", "10+3, break at s_hat", max(near), 1e-6
    yield f"static force, {len(far)} on the sheet", "8+3, break 1 to 3 mm off", max(far), 5e-4


def modes() -> Iterator[Row]:
    wanted = table("i_cantilever_modes.csv")["f_Hz"][:4]
    for degrees, least in ((8, 2e-3), (12, 1e-7)):
        by = Resolution(free_degrees=degrees)
        found = linearise(Simulation(plain(), None, UNDRIVEN, resolution=by)).frequencies_hz()
        yield "i modes 1 to 4, relative", f"{degrees}", _worst(found[:4] / wanted - 1.0), least
    rollers = table("ii_clamped_roller_overhang_modes.csv")
    for degrees, least in (((8, 3), 1e-4), ((12, 6), 1e-9)):
        rows = rollers[rollers["roller_at_over_l"] == 0.8]
        setup = ContactSetup(radius_m=0.8 * L, position_m=0.0)
        by = Resolution(degrees=degrees)
        found = linearise(Simulation(plain(), setup, UNDRIVEN, resolution=by)).frequencies_hz()
        error = _worst(found[:2] / rows[rows.dtype.names[-1]][:2] - 1.0)
        yield "ii roller at 0.8 l, modes 1, 2", f"{degrees[0]}+{degrees[1]}", error, least
    errors = []
    for row in table("iii_bar_on_short_sheet_modes.csv"):
        length = float(row["l_m"])
        bar = Elongation(
            length_m=float(row["bar_m"]), mass_per_length_kg_per_m=float(row["bar_kg_per_m"])
        )
        beam = plain(Field.constant(0.0, length), length_m=length, elongation=bar)
        found = linearise(Simulation(beam, None, UNDRIVEN)).frequencies_hz()
        errors.append(found[0] / row["f1_Hz"] - 1.0)
    yield "iii bar on a short sheet, relative", "10", _worst(np.array(errors)), 1e-13


def creep() -> Iterator[Row]:
    wanted, g, tau = table("iv_sls_creep_uniform_moment.csv"), 0.4, 0.1
    solid = Viscoelasticity(B_Nm2=B, shares=(g,), times_s=(tau,))
    beam = plain(material=solid, mass_per_length_kg_per_m=1e-12)
    drive = PrescribedMoment(lambda t, s: 20.0 * B + 0.0 * t * s)
    by = Resolution(step_s=tau / 40.0, free_degrees=4)
    one = Simulation(beam, None, drive, resolution=by)
    one.state.q[0], one.state.z[:] = wanted["k_per_m"][0], 0.0
    found = one.advance(drive, wanted["t_s"], TIP).curvature_per_m[:, 0]
    yield "iv creep, relative", "tau/40", _worst(found / wanted["k_per_m"] - 1.0), 2e-6


def line() -> Iterator[Row]:
    wanted = table("v_rc_line_unit_step.csv")
    steps, ones = np.diff(wanted["t_s"], prepend=0.0), np.ones(len(wanted))
    for terms, least in ((10, 5e-8), (12, 3e-10)):
        of = LineModes(cases.LINE, L, terms)
        found = of.respond(np.zeros(terms), steps, ones)[1:] @ of.at(np.linspace(0.0, L, 6)).T
        exact = np.stack([wanted[f"U_V_at_{10 * i}_mm"] for i in range(6)], axis=1)
        yield "v RC line, U in V", f"{terms} terms", _worst(found - exact), least
    rows = table("vi_sader_gamma.csv")
    gamma = hydrodynamic_function(rows[rows.dtype.names[0]])
    exact = rows["rectangle_real"] + 1j * rows["rectangle_imag"]
    yield "vi Sader's function, relative", "", _worst(gamma / exact - 1.0), 1e-13


def arc() -> Iterator[Row]:
    wanted = table("vii_manufactured_arc.csv")
    times, s = np.unique(wanted["t_s"]), np.unique(wanted["s_m"])
    drive, bent = PrescribedMoment(cases.arc_moment), Field.constant(40.0, L)
    for step_s, least in ((5e-4, 1.1e-4), (1.25e-4, 6.9e-6)):
        by = Resolution(step_s=step_s, tolerance_per_s2=1e-3)
        motion = simulate(plain(), None, drive, times, s_m=s, released_from=bent, resolution=by)
        error = _worst(motion.curvature_per_m.ravel() - wanted["k_per_m"]) / 40.0
        yield "vii arc turning by 2 rad, k, relative", _ms(step_s), error, least


def frequencies() -> Iterator[Row]:
    rows = table("viii_frequency_response_straight.csv")
    rest = Field.constant(0.0, L)
    for degrees, most_Hz, least in (((8, 3), 20.0, 1e-5), ((12, 5), 200.0, 1e-5)):
        by = Resolution(degrees=degrees, free_degrees=sum(degrees))
        free = linearise(Simulation(driven(rest), None, UNDRIVEN, resolution=by))
        setup = ContactSetup(radius_m=R, position_m=0.0)
        held = linearise(Simulation(driven(rest), setup, UNDRIVEN, resolution=by))
        tips, forces = [], []
        for row in rows[rows["f_Hz"] <= most_Hz]:
            p = 2j * np.pi * row["f_Hz"]
            tip = complex(row["tip_y_re_m_per_V"], row["tip_y_im"])
            force = complex(row["force_re_N_per_V"], row["force_im"])
            tips.append(free.transfer(p, TIP)[1][0] / tip - 1.0)
            forces.append(held.transfer(p, TIP)[2] / force - 1.0)
        fine = f"{degrees[0]}+{degrees[1]}"
        yield f"viii tip/V to {most_Hz:g} Hz, relative", fine, _worst(np.array(tips)), least
        yield f"viii force/V to {most_Hz:g} Hz", fine, _worst(np.array(forces)), least


def release() -> Iterator[Row]:
    wanted, held = table("ix_release_from_tip_load.csv"), cases.under_tip_load()
    beam = plain(material=material(prony=False, eta=2e-3))
    for step_s, least in ((1e-3, 1e-5), (2.5e-4, 6e-7)):
        by = Resolution(step_s=step_s, rho=1.0)
        motion = simulate(
            beam, None, UNDRIVEN, wanted["t_s"], s_m=TIP, released_from=held, resolution=by
        )
        gap = np.hypot(motion.x_m[:, 0] - wanted["tip_x_m"], motion.y_m[:, 0] - wanted["tip_y_m"])
        yield "ix release from 30 mm, tip in m", _ms(step_s), _worst(gap), least


def pulses() -> Iterator[Row]:
    for name, position_m in (("contact_p0", 0.0), ("contact_p15", 0.015), ("free", None)):
        wanted = table(f"x_pulse_{name}.csv")
        setup = None if position_m is None else ContactSetup(radius_m=R, position_m=position_m)
        for step_s, force_N, tip_m in ((1e-3, 1.1e-5, 7e-6), (2.5e-4, 7e-7, 6e-7)):
            motion = simulate(
                driven(), setup, cases.PULSES, wanted["t_s"], s_m=TIP,
                resolution=Resolution(step_s=step_s),
            )  # fmt: skip
            if setup is not None:
                error = _worst(motion.force_N - wanted["F_N"])
                yield f"x pulse, {name}, F in N", _ms(step_s), error, force_N
            error = _worst(motion.y_m[:, 0] - wanted["tip_y_m"])
            yield f"x pulse, {name}, tip in m", _ms(step_s), error, tip_m


def energies() -> Iterator[Row]:
    for name, setup in (
        ("free", None),
        ("on the rolls", ContactSetup(radius_m=R, position_m=0.015)),
    ):
        for step_s, least in ((1e-3, 1e-4), (2.5e-4, 1e-5)):
            one = Simulation(driven(), setup, cases.PULSES, resolution=Resolution(step_s=step_s))
            one.advance(cases.PULSES, np.array([1.0]))
            found = energy(one)
            share = _worst(found.imbalance) / _worst(found.work)
            yield f"energy balance, {name}, of the work", _ms(step_s), share, least


PARTS: tuple[Callable[[], Iterator[Row]], ...] = (
    static, modes, creep, line, arc, frequencies, release, pulses, energies,
)  # fmt: skip


def measure() -> Report:
    """All of it; about half a minute."""
    rows = [row for part in PARTS for row in part()]
    texts = tuple(
        (case, fine, f"{error:.1e}", f"{wanted:.1e}", "yes" if error <= wanted else "NO")
        for case, fine, error, wanted in rows
    )
    columns = ("case", "coefficients or step", "largest error", "wanted", "reached")
    figures = {f"{case}; {fine}": error for case, fine, error, _ in rows}
    return Report((Table("The moving sheet against exact motions", columns, texts),), figures)


def _worst(errors: np.ndarray) -> float:
    return float(np.max(np.abs(errors)))


def _ms(step_s: float) -> str:
    return f"{step_s * 1e3:g} ms"


if __name__ == "__main__":
    print(measure().text())

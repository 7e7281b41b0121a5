"""The moving chain against exact solutions, and how its error falls with links and steps."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from sim_hardware.world.motion import march
from sim_hardware.world.motion.fluid import hydrodynamic, immersion
from sim_hardware.world.motion.ladder import charge, ladder
from sim_hardware.world.motion.links import Links, room, step
from tests.sim_hardware.moving_chain import MU, B, L, R, driven, rows, sheet, straight, world

Floats = np.ndarray
STEP_S = 5e-4
_SHORT_S = 1e-5


def roots(links: Links, held_m: float | None = None) -> Floats:
    """The chain's roots s, of those with an imaginary part above 0, slowest first.

    They are the logarithms of the eigenvalues of one step, so short that it adds nothing.
    """
    n, p = links.spring_Nm.size - 1, links.share.size
    size, space = 2 * n + 2 * p * n, room(n)

    def stepped(x: Floats) -> Floats:
        phi, lag = np.zeros((3, n + 1)), np.zeros((2, p, n + 1))
        phi[0, 1:], phi[1, 1:] = x[:n], x[n : 2 * n]
        lag[1, :, 1:], lag[0, :, 1:] = x[2 * n :].reshape(2, p, n)
        phi[2] = phi[1]
        at = held_m or 0.0
        contact = np.array([at, 0.0, at])
        step(
            links, 1.0, _SHORT_S, phi, lag, 0, np.zeros(n + 1), contact, held_m is not None,
            at, 0.0, 1.0, space,
        )  # fmt: skip
        return np.concatenate(
            (phi[1, 1:], phi[2, 1:], lag[0, :, 1:].ravel(), lag[1, :, 1:].ravel())
        )

    small = 1e-7 * np.eye(size)
    matrix = np.array([stepped(e) - stepped(-e) for e in small]).T / 2e-7
    z = np.linalg.eigvals(matrix)
    s = np.log(z[(z.imag > 0) & (np.abs(z) > 0.3)]) / _SHORT_S
    return s[np.argsort(s.imag)]


def test_modes_are_those_of_the_cantilever_and_the_error_falls_with_the_links_squared() -> None:
    exact = np.array([row["omega_rad_per_s"] for row in rows("i_cantilever_modes.csv")[:4]])
    errors = {n: roots(straight(n))[:4].imag / exact - 1 for n in (16, 32, 64)}
    assert np.abs(errors[64]) == pytest.approx([1.3e-4, 1.2e-4, 3.0e-4, 1.13e-3], rel=0.05)
    assert errors[16][:2] / errors[32][:2] == pytest.approx(4.0, abs=0.15)
    assert errors[32] / errors[64] == pytest.approx(4.0, abs=0.15)


def test_nothing_but_the_material_damps_a_mode() -> None:
    free = roots(straight(24))[:6]
    assert np.max(np.abs(free.real / free.imag)) < 1e-9
    exact = rows("i_cantilever_modes.csv")[:2]
    for links, key in (
        (straight(64, viscous_s=1e-3), "kv"),
        (straight(64, share=np.array([0.25]), relax_s=np.array([0.02])), "sls"),
    ):
        found = roots(links)[:2]
        wanted = np.array([row[f"{key}_s_real"] + 1j * row[f"{key}_s_imag"] for row in exact])
        assert np.abs(found / wanted - 1).max() < 1.5e-4
        assert np.abs(found.real / wanted.real - 1).max() < 3e-4


def test_modes_on_rolls_are_those_of_the_exact_determinant() -> None:
    exact = rows("ii_clamped_roller_overhang_modes.csv")[:2]
    exact_Hz = np.array([row["f_Hz_B1.27e-6_mu5.775e-3_l0.05"] for row in exact])
    errors = {n: roots(straight(n), R)[:2].imag / (2 * np.pi) / exact_Hz - 1 for n in (32, 64)}
    assert errors[64] == pytest.approx([5e-5, 1.8e-3], rel=0.05)
    assert errors[32] / errors[64] == pytest.approx(4.0, abs=0.2)


def test_a_bar_on_a_short_sheet_swings_as_it_should() -> None:
    settings = world(configurations={"short": {**world().configurations["long"].model_dump(),
        "free_length_mm": 4.5, "elongation_mm": 40.0, "rest_curvature_per_m": 0.0}})  # fmt: skip
    settings = settings.model_copy(
        update={"loss": settings.loss.model_copy(update={"viscous_ms": 0.0, "shares": []})}
    )
    short = sheet(settings, None, "short").links
    found = roots(short._replace(share=np.zeros(0), relax_s=np.zeros(0)))[0].imag / (2 * np.pi)
    assert found == pytest.approx(rows("iii_bar_on_short_sheet_modes.csv")[0]["f1_Hz"], rel=1e-6)


def test_creep_under_a_constant_moment_is_that_of_the_standard_linear_solid() -> None:
    links = straight(16, share=np.array([0.4]), relax_s=np.array([0.1]), mass_kg=np.zeros(17))
    moment = np.full(17, 20 * B)

    def curvature(dt: float) -> Floats:
        # Before the step the springs stand still: the first instant is the elastic answer.
        phi, lag, space = np.zeros((3, 17)), np.zeros((2, 1, 17)), room(16)
        phi[:] = np.arange(17) * links.h_m * 20 / 1.4
        found = []
        for k in range(round(0.5 / dt)):
            phi[2] = phi[1]
            step(links, 1.0, dt, phi, lag, k % 2, moment, np.zeros(3), False, 0.0, 0.0, 1.0, space)
            phi[0], phi[1] = phi[1].copy(), phi[2].copy()
            found.append(phi[1, 9] - phi[1, 8])
        return np.array(found) / links.h_m

    exact = rows("iv_sls_creep_uniform_moment.csv")[1:6]
    at = np.array([row["t_s"] for row in exact])
    errors = [
        np.abs(
            curvature(dt)[np.rint(at / dt).astype(int) - 1] - [r["k_per_m"] for r in exact]
        ).max()
        for dt in (2e-3, 1e-3)
    ]
    assert errors[1] < 2e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.5)


def line_errors(cells: int) -> tuple[Floats, Floats]:
    """Of U at 10 to 50 mm in V and of the current, relative, after a unit step."""
    line = ladder(
        cells, L, STEP_S, ohm_per_m=4000.0, farad_per_m=0.3, bulk_ohm_m=0.5, leak_S_per_m=0.1,
        source_ohm=1.0,
    )  # fmt: skip
    exact = {round(row["t_s"] / STEP_S): row for row in rows("v_rc_line_unit_step.csv")}
    U, work, at = np.zeros(cells), np.empty(cells), (np.arange(cells) + 0.5) * L / cells
    off_V, off = [], []
    for k in range(1, max(exact) + 1):
        charge(line, 1.0, U, work)
        if k in exact:
            row = exact[k]
            found = CubicSpline(at, U)([0.01, 0.02, 0.03, 0.04])
            off_V.append(found - [row[f"U_V_at_{mm}_mm"] for mm in (10, 20, 30, 40)])
            off.append((line.now_S - line.back_S @ U) / row["current_A"] - 1)
    return np.array(off_V), np.array(off)


def test_the_electrodes_charge_as_the_line_does() -> None:
    coarse, fine = line_errors(32), line_errors(64)
    assert np.abs(fine[0]).max() < 1.1e-4
    assert np.abs(fine[1]).max() < 6e-4
    assert np.abs(coarse[0]).max() / np.abs(fine[0]).max() == pytest.approx(4.0, abs=0.5)
    assert np.abs(coarse[1]).max() / np.abs(fine[1]).max() == pytest.approx(4.0, abs=0.2)


def test_the_hydrodynamic_function_is_that_of_sader() -> None:
    for row in rows("vi_sader_gamma.csv"):
        found = hydrodynamic(next(iter(row.values())))
        assert found == pytest.approx(row["rectangle_real"] + 1j * row["rectangle_imag"], rel=1e-12)
    water = immersion("water", 0.011, 2 * np.pi * 0.71)
    assert water.added_kg_per_m / MU == pytest.approx(21, abs=0.5)


@pytest.mark.slow
def test_a_sheet_that_is_let_go_swings_as_the_converged_solution() -> None:
    exact = rows("ix_release_from_tip_load.csv")
    errors = {}
    for n in (40, 80):
        links = straight(n, viscous_s=2e-3)
        phi = np.zeros((3, n + 1))
        phi[:2] = bent_by_tip_load(links)
        space, found = room(n), [phi[1].copy()]
        for _ in range(1600):
            phi[2] = 2 * phi[1] - phi[0]
            step(
                links, 1.0, 2.5e-4, phi, np.zeros((2, 0, n + 1)), 0, np.zeros(n + 1), np.zeros(3),
                False, 0.0, 0.0, 1.0, space,
            )  # fmt: skip
            phi[0], phi[1] = phi[1].copy(), phi[2].copy()
            found.append(phi[1].copy())
        # At rest in the first two rows: it is let go half a step before the second.
        rows_ = np.array([found[0], *found])
        tips = np.array([tip(one, links.h_m) for one in (rows_[:-1] + rows_[1:]) / 2])
        at = [round(row["t_s"] / 2.5e-4) for row in exact]
        errors[n] = np.abs(tips[at] - [[r["tip_x_m"], r["tip_y_m"]] for r in exact]).max()
    assert errors[80] < 4e-5
    assert errors[40] / errors[80] == pytest.approx(4.0, abs=0.6)


def bent_by_tip_load(links: Links) -> Floats:
    """The chain's angles at rest under a dead load of 3 B/l^2 along y at its end."""
    load = 3 * B / L**2
    phi = np.zeros(links.spring_Nm.size)
    for _ in range(60):
        for_link = load * links.h_m * np.cos(phi[1:])
        for_link[-1] /= 2
        beyond = np.cumsum(for_link[::-1])[::-1]
        new = np.concatenate(([0.0], np.cumsum(beyond / links.spring_Nm[1:])))
        phi = (phi + new) / 2
    return phi


def tip(phi: Floats, h: float) -> Floats:
    length = np.full(phi.size, h)
    length[[0, -1]] = h / 2
    return np.array([length @ np.cos(phi), length @ np.sin(phi)])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "position_m", "most_N", "most_m"),
    [("contact_p0", 0.0, 2e-6, 5e-6), ("contact_p15", 0.015, 2e-6, 5e-6), ("free", None, 0, 3e-5)],
)
def test_pulses_give_the_converged_force_shape_and_current(
    name: str, position_m: float | None, most_N: float, most_m: float
) -> None:
    exact = rows(f"x_pulse_{name}.csv")
    times = np.arange(2000) * STEP_S
    drive_V = np.where(times < 0.0999, 0.0, np.where(times < 0.6999, 2.0, -2.0))
    found = driven(sheet(world(), position_m), drive_V)
    at = [round(row["t_s"] / STEP_S) for row in exact]
    force = np.array([row["F_N"] for row in exact])
    assert np.abs(found.rows[at, march.FORCE] - force).max() <= most_N
    tips = np.array([[row["tip_x_m"], row["tip_y_m"]] for row in exact])
    assert np.abs(found.tip_m()[at] - tips).max() < most_m
    current = np.array([row["current_A"] for row in exact])
    assert np.abs(found.current_A[at] - current).max() < 5e-5


@pytest.mark.slow
def test_the_force_converges_with_the_square_of_the_step_and_of_the_links() -> None:
    times = np.arange(0, 0.4, 1e-4)
    drive_V = 2.0 * np.sin(2 * np.pi * 3 * times) ** 2

    def force(links: int, block: int) -> Floats:
        means = drive_V.reshape(-1, block).mean(axis=1)
        found = driven(sheet(world(links, block * 0.1), 0.005), means)
        return found.rows[:: 40 // block, march.FORCE]

    finest = force(24, 2)
    of_step = [np.abs(force(24, block) - finest).max() for block in (20, 10)]
    assert of_step[0] / of_step[1] == pytest.approx(4.0, abs=0.7)
    many = force(96, 10)
    of_links = [np.abs(force(links, 10) - many).max() for links in (16, 32)]
    assert of_links[0] / of_links[1] == pytest.approx(4.6, abs=0.9)


@pytest.mark.slow
def test_a_sheet_under_a_voltage_that_stays_comes_to_rest_as_the_chain_at_rest() -> None:
    for name, position_m in (("long", 0.005), ("short", 0.01), ("long", None)):
        one = sheet(world(step_ms=2.0), position_m, name)
        found = driven(one, np.full(20_000, 2.0))
        line = one.line
        U = np.full(one.cells, 2.0)
        work = np.empty(one.cells)
        for _ in range(40_000):
            charge(line, 2.0, U, work)
        rest = one.rest(U, 1.0)
        assert found.phi_rad[-1] == pytest.approx(rest.phi_rad[: one.cells + 1], abs=1e-7)
        force_N = one.setup.stiffness_Nm2 * rest.along_per_m2
        assert found.rows[-1, march.FORCE] == pytest.approx(force_N, abs=1e-9)


@pytest.mark.slow
def test_work_of_the_moment_is_energy_and_loss() -> None:
    """Energy stored and lost against the work of Me, of a driven sheet with all its losses."""
    for position_m in (None, 0.0):
        balance = [energy_balance(position_m, step_ms) for step_ms in (0.5, 0.25)]
        assert balance[1] < 1e-4
        assert balance[0] / balance[1] == pytest.approx(4.0, abs=1.0)


def energy_balance(position_m: float | None, step_ms: float) -> float:
    """What is missing in the balance after a third of a second, over the work of Me."""
    one, dt = sheet(world(48, step_ms), position_m), step_ms * 1e-3
    links, count = one.links, round(0.36 / dt)
    times = (np.arange(count) + 0.5) * dt
    drive_V = 1.5 * np.sin(2 * np.pi * 4 * times)
    U, work = np.zeros(one.cells), np.empty(one.cells)
    moment = []
    for volts in drive_V:
        charge(one.line, volts, U, work)
        moment.append(one.moment_Nm(U, 1.0))
    phi = driven(one, drive_V).phi_rad
    turn = np.diff(phi, axis=1)
    rate = np.gradient(turn, dt, axis=0)
    strain, spring = turn - links.rest_rad[1:], links.spring_Nm[1:]
    Me = np.vstack((np.zeros(one.cells), moment))
    lost = links.viscous_s * spring * rate**2
    stored = 0.5 * spring * strain**2
    for share, tau in zip(links.share, links.relax_s, strict=True):
        z, x = strain.copy(), dt / (2 * tau)
        for k in range(1, len(z)):
            z[k] = ((1 - x) * z[k - 1] + x * (strain[k] + strain[k - 1])) / (1 + x)
        stored += 0.5 * share * spring * (strain - z) ** 2
        lost += share * spring * (strain - z) ** 2 / tau
    places = places_of(phi, links.h_m)
    speed = np.gradient(places, dt, axis=0)
    kinetic = 0.5 * (links.mass_kg[1:] * (speed**2).sum(axis=2)).sum(axis=1)
    k = count - 1
    trapezium = np.full(k + 1, dt)
    trapezium[[0, -1]] /= 2
    work_J = trapezium @ (Me * rate)[: k + 1].sum(axis=1)
    lost_J = trapezium @ lost[: k + 1].sum(axis=1)
    gained = kinetic[k] + stored[k].sum() - kinetic[0] - stored[0].sum()
    total = trapezium @ np.abs((Me * rate)[: k + 1].sum(axis=1))
    return abs(gained + lost_J - work_J) / total


def places_of(phi: Floats, h: float) -> Floats:
    """Where the hinges are (times, n, 2)."""
    length = np.full(phi.shape[1] - 1, h)
    length[0] = h / 2
    steps = length[:, None] * np.stack((np.cos(phi[:, :-1]), np.sin(phi[:, :-1])), axis=2)
    return np.cumsum(steps, axis=1)

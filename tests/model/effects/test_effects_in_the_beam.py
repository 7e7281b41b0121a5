"""Effects that depend on the solution, settled with the solver, against independent solutions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

from model import Condition, Curve, Measurements, Reading, SheetGeometry
from model.effects import Effect, catalogue, effect
from model.effects.conformance import acts, plausible
from model.effects.interface import BeamProblem, ContactSolution
from model.effects.sliding import slid
from model.identification.data.data_vector import data_vector_of
from model.identification.likelihood.contact_solution import ConfigurationModel
from model.mechanics.equilibrium import problems, solve
from model.mechanics.field import Field

R, B = 0.04, 1.27e-6
VOLTS = (0.0, 2.0, -2.0)
FREE = Curve(
    s_m=np.linspace(0.0, 0.05, 4), x_m=np.linspace(0.0, 0.05, 4), y_m=np.zeros(4)
)  # only to be there


@dataclass
class Bench:
    """Conditions of one sheet, with its base model."""

    configuration_model: ConfigurationModel
    base: BeamProblem

    def settled(
        self, effect: Effect, p: dict[str, float], rounds: int = 60
    ) -> tuple[BeamProblem, ContactSolution]:
        """Solve and apply in turn until nothing moves."""
        beam, contact = self.base, self.configuration_model.solve(self.base).contact
        for _ in range(rounds):
            before, beam = contact, effect.beam(self.base, contact, p)
            contact = self.configuration_model.solve(beam).contact
            moved = np.abs(contact.force_N - before.force_N), np.abs(contact.y_m - before.y_m)
            if np.nanmax(moved[0], initial=0.0) < 1e-14 and np.max(moved[1]) < 1e-13:
                return beam, contact
        raise AssertionError("it does not settle")


def bench(
    positions_mm: tuple[float | None, ...],
    length_m: float = 0.05,
    elongation_m: float = 0.0,
    k0: float = 0.0,
    bend: float = 0.0,  # Me/B at +2 V
    approach: str = "up",
    volts: tuple[float, ...] = VOLTS,
) -> Bench:
    rest = (np.zeros(1), np.array([k0]))
    sheet = SheetGeometry(
        configuration="it",
        free_length_m=length_m,
        width_m=0.011,
        thickness_m=0.21e-3,
        elongation_m=elongation_m,
        arc_radius_m=R,
        arc_origin_rad=0.0,
        initial_curvature=rest,
    )
    conditions = [
        Condition(
            configuration="it",
            position_m=None if at is None else at * 1e-3,
            voltage_V=volt,
            readings=()
            if at is None
            else (Reading(index=i, kind="kept" if volt else "zero", force_N=0.0),),
            curve=FREE if at is None else None,
            approach=approach,
        )
        for at in positions_mm
        for i, volt in enumerate(volts)
    ]
    seen = data_vector_of(Measurements(sheets={"it": sheet}, conditions=tuple(conditions)), "it")
    configuration_model = ConfigurationModel(seen, Field.constant(k0, length_m))
    eibm = {volt: np.sign(volt) * bend * (1.0 if volt > 0 else 0.8) for volt in VOLTS}
    return Bench(configuration_model, configuration_model.beam(B, eibm))


def brute(
    angle: float, free: float, law=lambda m: m, mu: float = 0.0, load: float = 0.0
) -> dict[str, float]:
    """Contact on the sheet by shooting for everything at once; quantities over B.

    `free`: Me/B; k0 = 0. `law`: from moments over B to curvature. `mu`: signed friction, the
    force on the sheet is -N n_hat + mu |N| t_hat. `load`: weight per length along -y of 50 mm.
    States: phi, x, y, and the integrals of x and of 1 beyond s, for the weight.
    """
    length = 0.05

    def slopes(sigma, u, p):
        nu, s_hat, phi_hat, x_end = p
        phi, x, y, area = u
        dx, dy = R * np.cos(angle) - x, R * np.sin(angle) - y
        t, n = np.cos(phi_hat), np.sin(phi_hat)
        a, b = dx * t + dy * n, dy * t - dx * n
        beyond = s_hat * (1.0 - sigma)
        # beyond the contact: an arc of curvature `free`, which its own weight hardly changes
        weight = -load * (area - beyond * x) - load * (length - s_hat) * (x_end - x)
        m = free - nu * a - mu * abs(nu) * b + weight
        return s_hat * np.stack([law(m), np.cos(phi), np.sin(phi), -x])

    def ends(ua, ub, p):
        _, s_hat, phi_hat, x_end = p
        tail = length - s_hat
        middle = ub[1] + 0.5 * tail * np.cos(ub[0] + 0.25 * free * tail)
        return np.array(
            [
                ua[0],
                ua[1],
                ua[2],
                ub[1] - R * np.cos(angle),
                ub[2] - R * np.sin(angle),
                ub[0] - phi_hat,
                ub[3],
                x_end - middle,
            ]
        )

    start = solve(problems(Field.constant(free, length), angle, R))
    s_hat, nu = float(start.s_hat_m[0]), float(start.nu[0])
    sigma = np.linspace(0.0, 1.0, 41)
    shape = start.shapes(sigma * s_hat)
    u = np.stack([shape.phi_rad[0], shape.x_m[0], shape.y_m[0], 0.02 * s_hat * (1.0 - sigma)])
    found = solve_bvp(
        slopes,
        ends,
        sigma,
        u,
        [nu, s_hat, float(start.phi_hat_rad[0]), 0.04],
        tol=1e-9,
        max_nodes=20000,
    )
    assert found.success, found.message
    nu, s_hat, phi_hat, _ = found.p
    gamma = phi_hat - angle
    along = nu * np.cos(gamma) - mu * abs(nu) * np.sin(gamma)
    return {"force": along * B, "normal": nu * B, "s_hat": s_hat, "gamma": gamma}


# ----------------------------------------------------------------------------------- compliances


@pytest.mark.parametrize("compliance", [20.0, 200.0])
def test_a_compliant_clamp_settles_where_a_search_by_hand_does(compliance: float):
    one = bench((0.0, 10.0, 25.0), k0=20.0, bend=25.0)
    beam, contact = one.settled(effect("clamp_compliance"), {"rotation_rad_per_Nm": compliance})
    for k in range(one.configuration_model.K):
        kappa = Field.constant(20.0 + float(one.base.eibm[k, 0]), 0.05)
        beta = float(one.base.stated_m[k]) / R

        def excess(tilt: float, kappa: Field = kappa, beta: float = beta) -> float:
            force = solve(problems(kappa, beta - tilt, R)).force(B)[0]
            return tilt + compliance * R * float(force)

        tilt = brentq(excess, -0.5, 0.5, xtol=1e-14)
        assert beam.tilt_rad[k] == pytest.approx(tilt, rel=1e-8)
        assert contact.force_N[k] == pytest.approx(-tilt / (compliance * R), rel=1e-8)


def test_a_load_cell_that_gives_way_stands_where_it_was_pushed_to():
    one = bench((0.0, 10.0, 25.0), k0=20.0, bend=25.0)
    c = 0.1
    beam, contact = one.settled(effect("load_cell_compliance"), {"compliance_mm_per_mN": c})
    assert beam.shift_m == pytest.approx(c * contact.force_N, rel=1e-9)
    rigid = bench(tuple(1e3 * (one.base.stated_m + beam.shift_m)), k0=20.0, bend=25.0)
    there = rigid.configuration_model.solve(rigid.base).contact.force_N.reshape(-1, 3)[
        np.arange(9), np.arange(9) % 3
    ]
    assert contact.force_N == pytest.approx(there, rel=1e-9)


def test_a_soft_elongation_takes_its_share_of_the_deflection():
    one = bench((0.2,), length_m=0.0045, elongation_m=0.04, volts=(0.0,))
    for c in (0.01, 0.3):
        _, contact = one.settled(
            effect("elongation_flexibility"), {"relative_compliance": c, "in_the_joint": 0.0}
        )
        far = R - 0.0045
        give = (R**3 - far**3) / 3.0 + c * far**3 / 3.0  # small deflections
        assert contact.force_N[0] == pytest.approx(-2e-4 * B / give, rel=1e-3)


def test_a_stiffness_along_the_sheet_gives_the_force_of_the_unit_load_theorem():
    one = bench((0.2,), volts=(0.0,))
    s = (np.arange(20000) + 0.5) * (R / 20000)
    for c in (-0.6, 0.6):
        _, contact = one.settled(effect("nonuniform_stiffness"), {"relative_change": c})
        stiffness = (1.0 + c * s / 0.05) / (1.0 + 0.5 * c)
        give = float(np.sum((R - s) ** 2 / stiffness)) * R / 20000
        assert contact.force_N[0] == pytest.approx(-2e-4 * B / give, rel=1e-4)


# -------------------------------------------------------------------------------------- nonlinear


@pytest.mark.slow
@pytest.mark.parametrize(("at_mm", "bend", "change"), [(5.0, 25.0, 0.2), (20.0, 0.0, -0.1)])
def test_a_nonlinear_sheet_settles_where_a_boundary_value_solver_does(at_mm, bend, change):
    one = bench((at_mm,), bend=bend, volts=(2.0,))
    _, contact = one.settled(
        effect("nonlinear_stiffness"), {"relative_change_at_10_per_m": change, "power": 0.0}
    )
    n = np.log2(1.0 + change)

    def law(m):
        u = m
        for _ in range(200):  # another way than the effect's
            u = u - (u * (1.0 + (u / 10.0) ** 2) ** n - m) / max(1.0, (1.0 + 2.0 * n) * 2.0)
        return u

    wanted = brute(at_mm * 1e-3 / R, bend, law)
    assert contact.force_N[0] == pytest.approx(wanted["force"], rel=2e-6)
    assert contact.s_hat_m[0] == pytest.approx(wanted["s_hat"], rel=1e-7)


def test_a_nonlinear_free_sheet_is_an_arc_of_the_laws_curvature():
    one = bench((None,), bend=30.0)
    _, contact = one.settled(
        effect("nonlinear_stiffness"), {"relative_change_at_10_per_m": 0.3, "power": 0.0}
    )
    for k, moment in enumerate((0.0, 30.0, -24.0)):
        u = contact.curvature[k, 0]
        assert u * (1.0 + (u / 10.0) ** 2) ** np.log2(1.3) == pytest.approx(moment, abs=1e-9)
        assert contact.end_phi_rad[k] == pytest.approx(0.05 * u, abs=1e-10)


# ---------------------------------------------------------------------------------------- gravity


def test_a_level_cantilever_sags_by_w_l4_over_8_B():
    one = bench((None,), volts=(0.0,))
    for load in (1e-4, -1e-4):
        _, contact = one.settled(effect("gravity"), {"load_N_per_m": load})
        end = np.polynomial.Polynomial.fit(one.configuration_model.s_m, contact.y_m[0], 6)(0.05)
        assert end == pytest.approx(-load * 0.05**4 / (8.0 * B), rel=2e-4)


@pytest.mark.parametrize("bend", [0.0, 25.0])
def test_a_held_heavy_sheet_settles_where_a_boundary_value_solver_does(bend: float):
    one = bench((15.0,), bend=bend, volts=(2.0,))
    load = 0.02
    light = one.configuration_model.solve(one.base).contact.force_N[0]
    _, contact = one.settled(effect("gravity"), {"load_N_per_m": load})
    wanted = brute(15e-3 / R, bend, load=load / B)["force"]
    assert contact.force_N[0] - light == pytest.approx(wanted - light, rel=2e-3)
    assert wanted < light  # it hangs on the object: pushes it less upward


# --------------------------------------------------------------------------------------- contact


@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_friction_gives_the_shape_and_the_force_of_a_tangential_load(mu: float):
    one = bench((-10.0, 25.0), k0=0.0, bend=30.0)
    _, contact = one.settled(effect("roll_friction"), {"coefficient": mu, "force_alone": 0.0})
    way = slid(one.base, contact)
    for k in range(one.configuration_model.K):
        wanted = brute(float(one.base.stated_m[k]) / R, float(one.base.eibm[k, 0]), mu=mu * way[k])
        assert contact.force_N[k] == pytest.approx(wanted["force"], rel=1e-5)
        assert contact.s_hat_m[k] == pytest.approx(wanted["s_hat"], rel=1e-6)
        # the moment has a kink at the contact, which few nodes round off
        assert contact.gamma_rad[k] == pytest.approx(wanted["gamma"], abs=5e-5)


def test_friction_changes_its_sign_with_the_side_of_approach():
    p = {"coefficient": 0.2, "force_alone": 0.0}
    one, two = (bench((25.0,), approach=a, volts=(0.0,)) for a in ("up", "down"))
    smooth = one.configuration_model.solve(one.base).contact.force_N[0]
    up, down = (b.settled(effect("roll_friction"), p)[1].force_N[0] for b in (one, two))
    # pushed up the sheet bends further and pushes back more; the rolls add to that
    assert up < smooth < down < 0.0


@pytest.mark.parametrize(
    ("scale", "there_mm"), [(0.0, 10.5), (1.0, 10.5 - 1.0 / 3.0), (2.0, 10.0 - 0.5 / 3.0)]
)
def test_a_position_error_is_another_position(scale: float, there_mm: float):
    """By one length, in proportion to the position, or to how far it is from 15 mm."""
    one, other = bench((10.0,), bend=25.0), bench((there_mm,), bend=25.0)
    _, contact = one.settled(effect("position_error"), {"offset_mm": 0.5, "scale": scale})
    assert contact.force_N == pytest.approx(
        other.configuration_model.solve(other.base).contact.force_N, rel=1e-10
    )


def test_a_clamp_angle_turns_a_straight_free_sheet():
    one = bench((1e3 * R * 0.03,), volts=(0.0,))
    _, contact = one.settled(effect("clamp_angle"), {"angle_rad": 0.03})
    assert contact.force_N[0] == pytest.approx(0.0, abs=1e-12)  # the object is where it points


def test_an_offset_of_the_rolls_lifts_the_free_position_to_the_sheets_left():
    one = bench((1e3 * R * np.arcsin(0.5e-3 / R),), volts=(0.0,))
    _, contact = one.settled(effect("roll_offset"), {"offset_mm": 0.5, "at_the_pressed": 0.0})
    assert contact.force_N[0] == pytest.approx(0.0, abs=1e-11)


# ------------------------------------------------------------------------------------ all of them


@pytest.mark.parametrize("name", [n for n, e in catalogue().items() if "beam" in acts(e)])
def test_an_effect_settles_within_four_rounds_and_does_not_add_up(name: str):
    one = bench((0.0, 15.0, 30.0, None), k0=18.0, bend=20.0)
    kind, p = effect(name), plausible(effect(name))
    _, at_rest = one.settled(kind, p)
    contact = one.configuration_model.solve(one.base).contact
    for _ in range(4):
        beam = kind.beam(one.base, contact, p)
        contact = one.configuration_model.solve(beam).contact
    assert np.nanmax(np.abs(contact.force_N - at_rest.force_N)) < 1e-7  # N: nobody measures that
    again = kind.beam(one.base, contact, p)
    for field in ("rest", "eibm", "bend", "soft", "tilt_rad", "shift_m", "offset_m"):
        one_, two = getattr(beam, field), getattr(again, field)
        assert two == pytest.approx(one_, abs=1e-3 * max(1e-9, float(np.max(np.abs(two)))))


def test_what_acts_on_a_base_without_the_effect_leaves_that_base_alone():
    one = bench((0.0, 15.0), bend=20.0)
    kept = replace(one.base, bend=one.base.bend.copy(), tilt_rad=one.base.tilt_rad.copy())
    for kind in catalogue().values():
        kind.beam(one.base, one.configuration_model.solve(one.base).contact, plausible(kind))
    assert np.array_equal(kept.bend, one.base.bend)
    assert np.array_equal(kept.tilt_rad, one.base.tilt_rad)

"""The menu: what each entry would add to a session, and what it would tell apart."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from model.discrepancy.next_measurement import choice
from model.discrepancy.next_measurement.choice import next_measurement
from model.discrepancy.next_measurement.extended_design import extended
from model.discrepancy.next_measurement.menu import MENU
from model.discrepancy.next_measurement.separation import Suspect, separation
from model.discrepancy.prepare import DiagnoseOptions, prepare
from model.discrepancy.search.evidence import candidates
from model.discrepancy.verdict import finding
from model.discrepancy.verdict.result import Next
from model.effects import effect
from model.identification.data.data_vector import data_vector_of
from model.identification.likelihood.mixed_model_fit import fit_mixed_model
from model.identification.likelihood.model_state import Found
from tests.cases import few
from tests.model.discrepancy.sessions import Case, Extras, base_fit, fitted, session

ENTRIES = {entry.name: entry for entry in MENU}


def suspects(pair, values, sizes):
    return [Suspect(*one) for one in zip(pair, values, sizes, strict=True)]


@pytest.mark.parametrize("entry", MENU, ids=list(ENTRIES))
def test_every_entry_adds_runs_that_are_none_of_the_session(entry):
    for name in ("long", "short"):
        one = data_vector_of(session(), name)
        added = entry.add(one)
        assert not {s.run for s in added} & {s.run for s in one.seen}
        keys = [(*s.run, s.voltage_V) for s in added]
        assert len(set(keys)) == len(keys) > 0
        for seen in added:  # a clock with a time of each kind for each reading
            assert len(seen.kept_clock.run_s) == len(seen.kept_N)
        assert entry.minutes(one) > 0.0


@pytest.mark.thorough
@pytest.mark.slow
def test_an_entry_is_measured_once_at_each_place_however_often_it_was_before():
    plain = data_vector_of(session(), "long")
    often = data_vector_of(
        session(Case(seed=1, extras=Extras(remounts=3, reversed_approach=True))), "long"
    )
    assert len(often.seen) > len(plain.seen)
    for entry in MENU:
        assert len(entry.add(often)) == len(entry.add(plain)), entry.name


def test_only_the_rig_turned_over_is_turned_over():
    one = data_vector_of(session(), "long")
    tilted = data_vector_of(
        replace(session(), conditions=tuple(
            replace(c, tilt_rad=np.pi) for c in session().conditions
        )), "long",
    )  # fmt: skip
    for entry in MENU:
        wanted = np.pi if entry.name == "turned_over" else 0.0
        for known in (one, tilted):
            assert {s.tilt_rad for s in entry.add(known)} == {wanted}, entry.name


def test_long_runs_go_on_with_the_same_pulses_at_three_positions():
    one = data_vector_of(session(), "long")
    usual = {(s.position_m, s.voltage_V): s for s in one.seen}
    added = ENTRIES["long_runs"].add(one)
    assert sorted({s.position_m for s in added}) == [0.0, 0.015, 0.03]
    for seen in added:
        like = usual[seen.position_m, seen.voltage_V]
        times = 3 if seen.voltage_V else 1
        count = len(like.kept_N)
        assert len(seen.kept_N) == len(seen.kept_clock.run_s) == times * count
        assert len(seen.own_curves[-len(seen.kept_N) :]) == times * count
        np.testing.assert_allclose(seen.kept_clock.run_s[:count], like.kept_clock.run_s)
        if seen.voltage_V:
            np.testing.assert_allclose(np.diff(seen.clock.pulse), 2.0)
            np.testing.assert_allclose(np.diff(seen.clock.driven_s), 1.2)


@pytest.mark.thorough
@pytest.mark.slow
def test_free_shapes_are_taken_when_measured_ones_are():
    """Amid pulses, not in the first one after 0 V, of which a lag or the first pulses say much."""
    added = [
        s for s in ENTRIES["free_shapes"].add(data_vector_of(session(), "long")) if s.voltage_V
    ]
    free = session(Case(seed=1, extras=Extras(free_shapes=True)))
    measured = [
        s for s in data_vector_of(free, "long").seen if s.free and not s.zero and s.voltage_V
    ]
    for one in added:
        like = next(s for s in measured if s.voltage_V == one.voltage_V).clock
        for name in ("pulse", "run_s", "driven_s", "wetted_s"):
            assert getattr(one.clock, name) == getattr(like, name), name
        assert one.clock.opposite == pytest.approx(-1.0)


@pytest.mark.slow
def test_the_load_cell_s_zero_tells_an_offset_from_a_meniscus():
    fit = base_fit()
    pair = [effect("force_offset"), effect("surface_tension")]
    values = [dict(candidates(fit, [e])[0].values) for e in pair]
    found = next_measurement(fit, [suspects(pair, values, [0.3, 0.3])])
    assert found.extra == "no_touch_zero"
    assert found.expected > 1.5 * found.separation


@pytest.mark.slow
@pytest.mark.parametrize("other", few(["initial_curvature", "force_offset"]))
def test_the_rig_turned_over_tells_weight_from_what_stays(other: str):
    """Weight changes sides; repeating everything as it was tells less."""

    def apart(fitted) -> float:
        pair = tuple(candidates(fitted, [effect(name)])[0] for name in ("gravity", other))
        return separation(fitted, pair, 1.0)

    fit = base_fit()
    now = apart(fit)
    over, again = (apart(extended(fit, ENTRIES[n])) for n in ("turned_over", "more_repeats"))
    assert over > 1.5 * again > now


@pytest.mark.slow
def test_half_a_voltage_begins_with_half_its_eibm_also_with_one_for_both_polarities():
    fit = fitted(session(), DiagnoseOptions(symmetric=True))
    more = extended(fit, ENTRIES["half_voltage"])
    bases, forward = more.problem.bases, more.problem.forward
    for c in range(len(forward.names)):
        eibm = bases.beam(forward, c, more.theta).eibm
        by_voltage = dict(zip(forward.configuration_models[c].voltage_V, eibm, strict=True))
        for volts in (1.0, -1.0):
            np.testing.assert_allclose(by_voltage[volts], 0.5 * by_voltage[2.0 * volts])
    # one |EIBM| for each size of voltage
    assert bases.size == fit.problem.bases.size + len(forward.names)


@pytest.mark.slow
@pytest.mark.parametrize("entry", [ENTRIES["more_repeats"], ENTRIES["no_touch_zero"]])
def test_an_extended_design_has_the_effects_and_the_noise_of_the_fit(entry):
    ready = prepare(session(), DiagnoseOptions())
    gravity = effect("gravity")
    usual = {k.name: k.prior_scale for k in gravity.parameters}
    known = Found(effect=gravity, values=dict.fromkeys(ready.problem.forward.names, usual))
    fit = fit_mixed_model(ready.problem, ready.theta, (known,))
    more = extended(fit, entry)
    assert more.active == fit.active
    assert more.linear.columns.shape[1] == fit.linear.columns.shape[1]
    assert np.linalg.norm(more.linear.columns[:, more.spans[0]]) > 0.0
    before, after = (
        dict(zip(one.problem.noise_names(), one.solution.log_sigma, strict=True))
        for one in (fit, more)
    )
    assert before.keys() <= after.keys()
    assert {name: after[name] for name in before} == before


@pytest.mark.thorough
def test_a_size_that_is_next_to_nothing_hides_no_difference():
    """What the first effect leaves of the second says nothing of how far the two are apart."""
    fit = base_fit()
    pair = [effect("gravity"), effect("clamp_angle")]
    values = [dict(candidates(fit, [e])[0].values) for e in pair]
    equal, unequal = (
        next_measurement(fit, [suspects(pair, values, s)]) for s in ([0.1, 0.1], [0.1, 1e-9])
    )
    assert unequal.separation > 0.5 * min(equal.separation, 8.0) > 0.0
    assert unequal.expected > unequal.separation


@pytest.mark.parametrize(("expected", "proposed"), [(0.0, False), (0.4, False), (4.0, True)])
def test_a_measurement_that_separates_next_to_nothing_is_not_proposed(
    monkeypatch, expected, proposed
):
    entry = Next(
        why="", extra="", between=(), separation=0.0, expected=expected, minutes=1.0, protocol={}
    )
    monkeypatch.setattr(finding, "next_measurement", lambda *_: entry)
    known = [effect(name) for name in ("gravity", "clamp_angle")]
    found = SimpleNamespace(
        effects=known, _suspects=list, outcome=SimpleNamespace(base=None), separating=None
    )
    named = [SimpleNamespace(name="gravity", confusable_with=("clamp_angle",), probabilities={})]
    assert (finding.Finding._next(found, named) is entry) == proposed


def test_of_several_alternatives_all_count_by_their_probability(monkeypatch):
    """The likeliest is separated best by one entry, two others by another one."""
    rivals = ("clamp_angle", "force_offset", "roll_offset")
    sigmas = {"now": (1.0, 1.0, 1.0), "likeliest": (3.0, 1.0, 1.2), "others": (1.1, 6.0, 5.0)}
    pairs = [[Suspect(effect(name), {}, 1.0) for name in ("gravity", one)] for one in rivals]
    fitted = SimpleNamespace(
        problem=SimpleNamespace(forward=SimpleNamespace(data_vectors=["long"]))
    )
    entries = [
        SimpleNamespace(name=name, what=name, minutes=lambda _: 10.0, protocol={})
        for name in ("likeliest", "others")
    ]
    monkeypatch.setattr(choice, "MENU", entries)
    monkeypatch.setattr(choice, "equally_long", lambda _, pair: tuple(pair))
    monkeypatch.setattr(choice, "extended", lambda _, entry: entry.name)
    monkeypatch.setattr(
        choice, "distance",
        lambda of, pair: sigmas["now" if of is fitted else of][rivals.index(pair[1].effect.name)],
    )  # fmt: skip
    sure = next_measurement(fitted, pairs, (0.9, 0.05, 0.05))
    assert (sure.extra, sure.between, sure.separation, sure.expected) == (
        "likeliest", ("gravity", "clamp_angle"), 1.0, 3.0,
    )  # fmt: skip
    unsure = next_measurement(fitted, pairs, (0.4, 0.3, 0.2))
    assert (unsure.extra, unsure.between) == ("others", ("gravity", "force_offset"))
    assert unsure.why == ("others, to separate gravity from force offset and roll offset")

"""Locations of discrepancy: ours conform, and others are added by being installed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model import ModelError, predict
from model.discrepancy.search.nonparametric_terms import unknowns
from model.effects import effect
from model.effects.conformance import faults as faults_of_effect
from model.locations import location, locations, origins
from model.locations.conformance import faults
from model.locations.quantities import LoadCellInput
from model.plugins import PluginWarning
from model.sheet.beam_problem import ActiveEffect, Profile
from tests.model.discrepancy.sessions import base_fit
from tests.model.distributions import install

HUMIDITY = """
from dataclasses import dataclass, replace
from model.locations import Location
from model.locations.basis import bases_of, cosine_wave


@dataclass(frozen=True, kw_only=True)
class Humidity(Location):
    def beam(self, beam, term):
        if term.along != "s":
            return beam
        return replace(beam, rest=beam.rest + 2.0 * term(beam.s_m))

    def bases(self, at):
        yield from bases_of(self, at, [cosine_wave(j) for j in range(3)], along="s", part="s")


LOCATION = Humidity(
    name="humidity", meaning="the air", depends="the same at all voltages", unit="1/m", order=45
)
MUTE = Humidity(name="mute", meaning="", depends="d", unit="1/m", order=1)
NUMBER = 3


@dataclass(frozen=True, kw_only=True)
class Careless(Humidity):
    def beam(self, beam, term):
        beam.rest += term(beam.s_m)
        return beam


CARELESS = Careless(name="careless", meaning="m", depends="d", unit="1/m", order=1)


@dataclass(frozen=True, kw_only=True)
class Constant(Humidity):
    def beam(self, beam, term):
        return replace(beam, rest=beam.rest + 1.0)


CONSTANT = Constant(name="constant", meaning="m", depends="d", unit="1/m", order=1)
"""


@pytest.mark.parametrize("name", locations())
def test_a_location_conforms(name):
    assert faults(location(name)) == []
    assert location(name).name == name


def test_locations_are_in_the_order_of_presentation():
    orders = [one.order for one in locations().values()]
    assert orders == sorted(orders)
    assert origins() == {}


def test_an_unknown_location_is_named_with_those_there_are():
    with pytest.raises(ModelError, match=r"no location of discrepancy 'eimb'.*mean 'eibm'\?"):
        location("eimb")


@pytest.mark.parametrize(
    ("constant", "fault"),
    [
        ("NUMBER", "it is of type int"),
        ("MUTE", "its meaning is empty"),
        ("CARELESS", "changes its argument BeamProblem"),
        ("CONSTANT", "that is 0 changes something"),
    ],
)
def test_a_location_that_cannot_be_used_is_left_out_with_a_sentence(
    tmp_path, monkeypatch, constant, fault
):
    name = f"broken_{constant.lower()}"
    install(tmp_path, name, f"[labrig.locations]\nhumidity = {name}:{constant}\n", HUMIDITY)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.warns(PluginWarning, match=fault):
        assert "humidity" not in locations()


@pytest.mark.slow
def test_a_location_of_another_distribution_is_predicted_and_looked_for(
    tmp_path, monkeypatch, truth
):
    profile = Profile(along="s", at=(0.0, 0.05), values=(2.0, 2.0), sigma=(0.0, 0.0), unit="1/m")
    ours = truth.with_effects(
        ActiveEffect(name="unknown", profile=profile, location="rest_curvature")
    )
    theirs = truth.with_effects(ActiveEffect(name="unknown", profile=profile, location="humidity"))
    with pytest.raises(ModelError, match="no location of discrepancy 'humidity'"):
        predict(theirs, "long", 0.02, 2.0)
    install(tmp_path, "moist_air", "[labrig.locations]\nhumidity = moist_air:LOCATION\n", HUMIDITY)
    monkeypatch.syspath_prepend(tmp_path)
    assert list(locations()).index("humidity") == list(locations()).index("compliance") + 1
    assert origins() == {"humidity": "moist_air 1.0"}
    twice = replace(profile, values=(4.0, 4.0))
    ours = truth.with_effects(
        ActiveEffect(name="unknown", profile=twice, location="rest_curvature")
    )
    wanted = predict(ours, "long", 0.02, 2.0)
    found = predict(theirs, "long", 0.02, 2.0)
    assert pytest.approx(wanted.F_N, rel=1e-9) == found.F_N
    np.testing.assert_allclose(found.y_m, wanted.y_m, atol=1e-9)
    assert "unknown:humidity" in [one.name for one in unknowns(base_fit())]
    assert faults_of_effect(replace(effect("initial_curvature"), location="humidity")) == []


@pytest.mark.parametrize(("along", "felt"), [("session", 1.0), ("position", 0.0), ("force", 0.0)])
def test_without_contact_the_load_cells_own_zero_alone_is_felt(along: str, felt: float):
    term = Profile(along=along, at=(0.0, 1.0), values=(0.2, 0.2), sigma=(0.0, 0.0), unit="mN")
    one, none = np.ones(1), np.zeros(1)
    weighed = LoadCellInput(
        force_N=none, normal_N=none, gamma_rad=none, position_m=none, voltage_V=none,
        session=0.5 * one, touching=none,
    )  # fmt: skip
    assert location("load_cell").force(weighed, term) == pytest.approx([felt * 2e-4])

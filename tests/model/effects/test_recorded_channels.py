"""Values of further channels reach the methods of an effect, reading by reading."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model import Condition, Measurements, Reading
from model.effects import Effect, EffectParameter
from model.effects.conformance import faults
from model.identification.data.data_vector import data_vector_of
from model.locations.examples import example_beam, example_clock, example_weighed
from model.locations.quantities import AcquisitionTimes
from model.sheet.effect_hooks import Acting, added_force_N, course, load_cell_input
from tests.model.conftest import geometry

NAME = "temperature_degC"


@dataclass(frozen=True)
class Warm(Effect):
    """The load cell's zero and the EIBM go with the temperature."""

    def course(self, clock, p):
        warmer = p["per_K"] * (clock.channel(NAME, 20.0) - 20.0)
        return warmer, np.zeros_like(warmer)

    def force(self, weighed, p):
        return p["per_K"] * 1e-3 * (weighed.channel(NAME, 20.0) - 20.0)


WARM = Warm(
    name="warm", meaning="m", form="f", location="time", signature="s", isolates="i", source="s",
    channels=(NAME,),
    parameters=(EffectParameter(name="per_K", meaning="of both", unit="1/K", prior_scale=0.01),),
)  # fmt: skip
ACTING = Acting(WARM, {"per_K": 0.01})


def test_an_effect_of_a_channel_conforms_and_must_name_it():
    assert faults(WARM) == []
    assert "it changes nothing" in " ".join(faults(replace(WARM, channels=())))
    assert "names with units" in " ".join(faults(replace(WARM, channels=("a b",))))


def test_a_reading_without_a_value_has_the_usual_one():
    clock = replace(example_clock(), channels={NAME: np.full(32, 25.0)})
    clock.channels[NAME][3] = np.nan
    found = clock.channel(NAME, 20.0)
    assert found[3] == 20.0
    assert np.all(np.delete(found, 3) == 25.0)
    np.testing.assert_array_equal(clock.channel("humidity_percent", 50.0), np.full(32, 50.0))


def test_times_keep_their_values_when_some_are_chosen_or_joined():
    clock = replace(example_clock(), channels={NAME: np.arange(32.0)})
    odd = clock.of(np.arange(32) % 2 == 1)
    np.testing.assert_array_equal(odd.channel(NAME, 0.0), np.arange(1.0, 32.0, 2.0))
    both = AcquisitionTimes.joined([odd, example_clock()])
    np.testing.assert_array_equal(both.channel(NAME, 7.0)[15:18], [31.0, 7.0, 7.0])
    assert clock.of(np.zeros(32, dtype=bool)).channels == {}


def test_the_load_cell_has_the_values_in_the_order_of_time():
    weighed = replace(example_weighed(), channels={NAME: np.arange(32.0)})
    weighed = replace(weighed, slid=np.zeros(32), run_s=np.zeros(32), pulse_s=np.zeros(32))
    backwards = np.arange(32)[::-1]
    added = added_force_N([ACTING], weighed, backwards)
    np.testing.assert_allclose(added, 1e-5 * (np.arange(32.0) - 20.0))
    beam, contact = example_beam()
    clock = replace(beam.clock, channels={NAME: np.full(len(beam.reading_of), 21.0)})
    given = load_cell_input(beam, contact, clock, beam.reading_of)
    np.testing.assert_array_equal(given.channel(NAME, 0.0), clock.channels[NAME])


def test_values_of_readings_are_those_of_the_measurements():
    readings = tuple(
        Reading(index=i, kind="kept", force_N=1e-3 + 1e-6 * i,
                other_values={} if i == 2 else {NAME: 20.0 + i})
        for i in range(4)
    )  # fmt: skip
    condition = Condition(
        configuration="long", position_m=0.01, voltage_V=2.0, readings=readings, curve=None
    )
    measured = Measurements(sheets={"long": geometry("long")}, conditions=(condition,))
    (seen,) = data_vector_of(measured, "long").seen
    changed = course(ACTING, seen.clock)
    assert changed is not None
    np.testing.assert_allclose(changed[0], [0.0, 0.01, 0.0, 0.03], atol=1e-12)

"""The four kinds of protocol, and what each refuses."""

import math

import pytest

from protocols import Hold, PulseTrain, ReadingKind, ScheduleError, Staircase, StepResponse

KEPT, ZERO, DISCARDED = ReadingKind.KEPT, ReadingKind.ZERO, ReadingKind.DISCARDED


def corners(protocol):
    steps, _, duration_s = protocol.steps_and_readings()
    return [(s.time_s, s.voltage_V) for s in steps], duration_s


def test_rests_are_at_0_V_after_every_pulse():
    train = PulseTrain(
        voltages_V=(1.0,), zero_readings=0, pulses_discarded=1, readings_per_voltage=1, rest_s=0.4
    )
    assert corners(train) == ([(0, 1), (0.6, 0), (1.0, 1), (1.6, 0)], 2.0)
    assert [(r.step, r.kind) for r in train.steps_and_readings()[1]] == [(0, DISCARDED), (2, KEPT)]


def test_a_step_response_is_watched_before_during_and_after():
    response = StepResponse(
        voltage_V=1.5, hold_s=2.0, sample_every_s=0.5, before_s=1.0, after_s=1.2
    )
    assert corners(response) == ([(0, 0), (1.0, 1.5), (3.0, 0)], 4.2)
    readings = response.steps_and_readings()[1]
    assert [(r.step, r.delay_s, r.kind) for r in readings] == [
        (0, 0.5, ZERO),
        (1, 0.5, KEPT),
        (1, 1.0, KEPT),
        (1, 1.5, KEPT),
        (2, 0.5, DISCARDED),
        (2, 1.0, DISCARDED),
    ]


def test_a_staircase_takes_one_reading_a_stair_and_returns_to_0_V():
    stairs = Staircase(voltages_V=(0.0, 1.0, 0.0, -1.0), dwell_s=1.0)
    assert corners(stairs) == ([(0, 0), (1, 1), (2, 0), (3, -1), (4, 0)], 4.0)
    readings = stairs.steps_and_readings()[1]
    assert [(r.step, r.kind) for r in readings] == [(0, ZERO), (1, KEPT), (2, KEPT), (3, KEPT)]


def test_a_hold_begins_relaxed_and_alternates():
    hold = Hold(voltage_V=2.0, hold_s=1.0, relax_s=0.5, cycles=2, sample_every_s=0.4)
    assert corners(hold) == ([(0, 0), (0.5, 2), (1.5, 0), (2.0, 2), (3.0, 0)], 3.5)
    kinds = [r.kind for r in hold.steps_and_readings()[1]]
    assert kinds == [ZERO, KEPT, KEPT, DISCARDED, KEPT, KEPT, DISCARDED]


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: PulseTrain(voltages_V=()), "voltages_V is empty"),
        (lambda: PulseTrain(voltages_V=(2.0, math.nan)), "not a finite number"),
        (lambda: PulseTrain(voltages_V=(2.0,)), "without an edge"),
        (lambda: PulseTrain(voltages_V=(2.0, 1.0, 2.0)), "without an edge"),
        (lambda: PulseTrain(pulse_s=0.0), "pulse_s = 0 must be larger than 0"),
        (lambda: PulseTrain(sample_at_s=0.55), "0.55 ± 0.1 s must lie between 0 and pulse_s"),
        (lambda: PulseTrain(sample_at_s=0.05), "must lie between"),
        (lambda: PulseTrain(rest_s=-0.1), "rest_s = -0.1 must not be negative"),
        (lambda: PulseTrain(zero_readings=-1), "zero_readings = -1 must be a whole number"),
        (lambda: PulseTrain(readings_per_voltage=0), "readings_per_voltage = 0 must be"),
        (lambda: PulseTrain(pulses_discarded=1.5), "pulses_discarded = 1.5 must be"),
        (lambda: PulseTrain(zero_readings=True), "zero_readings = True must be"),
        (lambda: StepResponse(voltage_V=0.0), "voltage_V = 0 is no step"),
        (lambda: StepResponse(hold_s=0.5, sample_every_s=0.5), "no reading fits"),
        (lambda: StepResponse(sample_every_s=1e-6), "more than 10000 readings"),
        (lambda: StepResponse(after_s=math.inf), "after_s = inf is not a finite number"),
        (lambda: Staircase(voltages_V=(0.0,)), "no voltage but 0"),
        (lambda: Staircase(voltages_V=(1.0, 1.0)), "without an edge"),
        (lambda: Staircase(dwell_s=0.5), "between 0 and dwell_s = 0.5 s"),
        (lambda: Hold(cycles=0), "cycles = 0 must be a whole number, 1 or more"),
        (lambda: Hold(voltage_V=0.0), "holds nothing"),
        (lambda: Hold(relax_s=0.0), "relax_s = 0 must be larger than 0"),
    ],
)
def test_nonsense_is_refused_with_one_sentence_that_names_the_key(make, says):
    with pytest.raises(ScheduleError) as refused:
        make()
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)

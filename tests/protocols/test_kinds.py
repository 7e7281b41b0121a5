"""Kinds of protocol: their runs, what each refuses, and the conformance test of all of them."""

import itertools
import math
import threading
import time
from dataclasses import dataclass, field
from typing import ClassVar

import pytest

from labrig.config import PROTOCOLS
from labrig.testing import protocol_faults
from protocols import ProtocolKind, ReadingKind, ScheduleError
from protocols.extras.release import Release
from protocols.kinds.conformance import faults
from protocols.kinds.fields import count, duration, voltage
from protocols.kinds.hold import Hold
from protocols.kinds.pulse_train import PulseTrain
from protocols.kinds.staircase import Staircase
from protocols.kinds.step_response import StepResponse
from protocols.planning.builder import Builder

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
        (lambda: PulseTrain(voltages_V=()), "voltages_V has 0 entries; must be at least 1"),
        (lambda: PulseTrain(voltages_V=(2.0, math.nan)), "not a finite number"),
        (lambda: PulseTrain(voltages_V=(2.0,)), "without an edge"),
        (
            lambda: PulseTrain(voltages_V=(2.0, 1.5, 2.0), rest_s=0.6),
            "has 2 V twice; state it once",
        ),
        (lambda: PulseTrain(voltages_V=(2.0, 0.0, -1.5)), "entry 2 of voltages_V is 0 V"),
        (lambda: Release(voltages_V=(2.0, 0.0)), "write 2.0 if 2,0 is one number"),
        (
            lambda: PulseTrain(voltages_V=(31.0, -2.0)),
            "an entry of voltages_V = 31 must be at most",
        ),
        (lambda: PulseTrain(pulse_s=0.0), "pulse_s = 0 must be larger than 0"),
        (lambda: PulseTrain(sample_at_s=0.55), "0.55 ± 0.1 s must lie between 0 and pulse_s"),
        (lambda: PulseTrain(sample_at_s=0.05), "must lie between"),
        (lambda: PulseTrain(rest_s=-0.1), "rest_s = -0.1 must be at least 0"),
        (lambda: PulseTrain(zero_readings=-1), "zero_readings = -1 must be at least 0"),
        (lambda: PulseTrain(readings_per_voltage=0), "readings_per_voltage = 0 must be at least 1"),
        (lambda: PulseTrain(pulses_discarded=1.5), "pulses_discarded = 1.5 must be a whole number"),
        (lambda: PulseTrain(zero_readings=True), "zero_readings = True must be a whole number"),
        (lambda: StepResponse(voltage_V=0.0), "voltage_V = 0 is no step"),
        (lambda: StepResponse(hold_s=0.5, sample_every_s=0.5), "no reading fits"),
        (lambda: StepResponse(sample_every_s=1e-6), "more than 10000 readings"),
        (lambda: StepResponse(after_s=math.inf), "after_s = inf is not a finite number"),
        (lambda: Staircase(voltages_V=(0.0,)), "no voltage but 0"),
        (lambda: Staircase(voltages_V=(1.0, 1.0)), "without an edge"),
        (lambda: Staircase(dwell_s=0.5), "between 0 and dwell_s = 0.5 s"),
        (lambda: Hold(cycles=0), "cycles = 0 must be at least 1"),
        (lambda: Hold(voltage_V=0.0), "holds nothing"),
        (lambda: Hold(relax_s=0.0), "relax_s = 0 must be larger than 0"),
    ],
)
def test_nonsense_is_refused_with_one_sentence_that_names_the_key(make, says):
    with pytest.raises(ScheduleError) as refused:
        make()
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("voltages_V", "says"),
    [
        ((2.0, 0.0, -2.0, 0.0), "write 2.0 if 2,0 is one number"),
        ((1.0, 5.0, -1.0, 5.0), "write -1.5 if -1,5 is one number"),
    ],
)
def test_a_decimal_comma_among_the_voltages_of_pulses_is_pointed_out(voltages_V, says):
    with pytest.raises(ScheduleError) as refused:
        PulseTrain(voltages_V=voltages_V)
    assert says in str(refused.value)


@pytest.mark.parametrize("voltages_V", [(2.5, -2.0, 0.0), (2.0, -2.0, 2.0, -2.0), (0.0, 2.0)])
def test_what_is_no_decimal_comma_has_no_hint_at_one(voltages_V):
    with pytest.raises(ScheduleError) as refused:
        PulseTrain(voltages_V=voltages_V)
    assert "one number" not in str(refused.value)


@pytest.mark.parametrize("name", sorted(PROTOCOLS.parts()))
def test_every_kind_of_the_folder_conforms_and_is_called_after_its_module(name):
    kind = PROTOCOLS.get(name)
    assert faults(kind) == []
    assert kind.name == name


@dataclass(frozen=True, kw_only=True)
class Flash(ProtocolKind):
    """One short pulse."""

    name: ClassVar[str] = "flash"
    voltage_V: float = voltage(1.0, "of the pulse")
    pulse_s: float = duration(0.2, "length of the pulse")

    def steps_and_readings(self):
        run = Builder()
        run.step(self.voltage_V, self.pulse_s)
        run.reading(self.pulse_s / 2, 0.01, KEPT)
        return run.finish()


def test_a_kind_of_ones_own_needs_nothing_but_steps_and_readings():
    assert faults(Flash) == []
    assert Flash().scaled(0.5).driven_V == (0.5,)
    assert Flash().at_voltages((-2.0,)) == Flash(voltage_V=-2.0)
    assert Flash().pulses().voltages_V == (1.0,)
    with pytest.raises(ScheduleError, match="no key makes it take more readings"):
        Flash().longer(3)
    with pytest.raises(ScheduleError, match="2 voltages do not fit"):
        Flash().at_voltages((1.0, 2.0))


def test_a_longer_protocol_takes_more_readings_of_each_voltage():
    assert PulseTrain().longer(3).readings_per_voltage == 30
    assert Hold().longer(2).cycles == 6


def left_energised(self):
    steps, readings, duration_s = Flash.steps_and_readings(self)
    return steps[:1], readings, duration_s


def read_too_late(self):
    run = Builder()
    run.step(self.voltage_V, self.pulse_s)
    run.reading(self.pulse_s, 0.01, KEPT)
    return run.finish()


def read_before_its_first_step(self):
    run = Builder()
    run.reading(0.1, 0.01, KEPT)
    run.step(self.voltage_V, self.pulse_s)
    return run.finish()


def in_millivolts(self):
    run = Builder()
    run.step(1e3 * self.voltage_V, self.pulse_s)
    run.reading(self.pulse_s / 2, 0.01, KEPT)
    return run.finish()


def in_milliseconds(self):
    run = Builder()
    run.step(self.voltage_V, 600.0)
    run.reading(300.0, 0.01, KEPT)
    return run.finish()


def other_kind(**members):
    return dataclass(frozen=True, kw_only=True)(
        type("Other", (Flash,), {"__doc__": "x", **members})
    )


def with_field(name):
    members = {name: count(3, "of something", at_least=1)}
    return other_kind(__annotations__={name: "int"}, **members)


@pytest.mark.parametrize(
    ("kind", "says"),
    [
        (3, "no subclass of"),
        (PulseTrain(), "no subclass of"),
        (other_kind(steps_and_readings=left_energised), "leaves 1 V at the sheet"),
        (other_kind(steps_and_readings=read_too_late), "is not over when its step is"),
        (other_kind(name="Not a name"), "small letters"),
        (
            other_kind(steps_and_readings=read_before_its_first_step),
            "its defaults are refused: a reading comes before the first step",
        ),
        (
            other_kind(steps_and_readings=lambda _: Builder().finish()),
            "refused: it has no step",
        ),
        (
            other_kind(steps_and_readings=lambda _: None),
            "steps_and_readings returned NoneType, not the steps, readings and duration",
        ),
        (other_kind(steps_and_readings=lambda _: Builder()), "returned Builder, not the steps"),
        (other_kind(steps_and_readings=in_millivolts), "by default it drives 1000 V"),
        (other_kind(__annotations__={"more": "float"}, more=1.0), "more has no description"),
        (
            other_kind(
                __annotations__={"more": "float"},
                more=field(default=1.0, metadata={"description": "x"}),
            ),
            "more has no lower or no upper bound",
        ),
        (with_field("pulses"), "its field pulses has a name that ProtocolKind uses itself"),
        (with_field("at_voltages"), "its field at_voltages has a name that ProtocolKind"),
        (with_field("name"), "its `name` is not made of small letters"),
        (with_field("settings"), "its field settings has a name that every table uses itself"),
        (other_kind(__post_init__=lambda _: None), "accepts voltage_V = -31"),
        (other_kind(check=lambda _: (_ for _ in ()).throw(ScheduleError("x"))), "are refused: x"),
        (
            other_kind(
                __annotations__={"voltage_V": "float"},
                voltage_V=field(default=1.0, metadata={**voltage(1.0, "x").metadata, "unit": ""}),
            ),
            "does not halve its voltages",
        ),
    ],
)
def test_a_bad_kind_is_told_what_is_wrong(kind, says):
    assert says in "; ".join(faults(kind))


def test_times_in_ms_are_asked_about_but_a_rig_may_allow_a_long_run():
    kind = other_kind(steps_and_readings=in_milliseconds)
    assert faults(kind) == []  # of the loader
    assert protocol_faults(kind) == [
        "by default a run is 600 s under voltage: are its times in ms, not in s?"
    ]


def test_what_a_kind_raises_is_one_of_its_faults():
    kind = other_kind(steps_and_readings=lambda _: 1 / 0)
    (fault,) = protocol_faults(kind)
    assert fault.startswith("its code raised ZeroDivisionError: division by zero (test_kinds.py, ")


def test_a_kind_that_waits_for_ever_is_not_waited_for(monkeypatch):
    monkeypatch.setattr("labrig.testing.blocking.BLOCKS_S", 0.3)
    never = threading.Event()

    def asks_a_server(self):
        never.wait(20.0)
        return Flash.steps_and_readings(self)

    (fault,) = protocol_faults(other_kind(steps_and_readings=asks_a_server))
    never.set()
    said = "its asks_a_server has not returned in 0.3 s: it blocks (test_kinds.py, line "
    assert fault.startswith(said)


def test_a_kind_that_computes_for_a_while_is_waited_for(monkeypatch):
    monkeypatch.setattr("labrig.testing.blocking.BLOCKS_S", 0.2)
    calls = itertools.count()

    def computes(self):
        until_s = time.process_time() + (0.0 if next(calls) else 0.5)  # once: it is asked often
        while time.process_time() < until_s:
            pass
        return Flash.steps_and_readings(self)

    assert protocol_faults(other_kind(steps_and_readings=computes)) == []

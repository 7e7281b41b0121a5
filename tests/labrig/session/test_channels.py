"""A session records any channels: their raw samples, and a value of each in every reading."""

from __future__ import annotations

from dataclasses import replace

import h5py
import numpy as np
import pytest

from drivers.interfaces import SignalBlock
from labrig.errors import BadInputError
from labrig.session import SessionWriter, open_session, recover, verify
from labrig.session.recording.journal import Journal, journal_path
from labrig.session.recording.rows import Translator
from protocols import Channel
from protocols.execution import events as ev
from tests.cases import few
from tests.labrig.session.session_recording import (
    CHANNELS,
    session_events,
    settings,
    setup_of,
    small_schedule,
)

TEMPERATURE = Channel(
    name="temperature", quantity="temperature", unit="degC", range_V=1.0, gain=100.0, offset=-3.0
)
FOUR = (*CHANNELS, TEMPERATURE)


def warmed(event: ev.Event) -> ev.Event:
    """The event of a rig whose fourth input is at 0.25 V."""
    if isinstance(event, ev.RunStarted):
        return replace(event, channels=tuple(channel.name for channel in FOUR))
    if isinstance(event, ev.SignalsArrived):
        volts = np.vstack([event.block.volts, np.full((1, event.block.volts.shape[1]), 0.25)])
        return replace(event, block=SignalBlock(event.block.first_index, volts, event.block.read_s))
    if isinstance(event, ev.ReadingTaken):
        return replace(event, values={**event.values, "temperature_degC": 22.0})
    return event


def recorded(path, channels=FOUR):
    with SessionWriter(path, **settings(small_schedule()) | {"channels": channels}) as writer:
        for event in session_events(small_schedule()):
            writer.handle(warmed(event))
    return path


def check_temperature(path):
    assert all(check.ok for check in verify(path))
    with open_session(path) as session:
        assert session.signals[3] == TEMPERATURE
        assert session.signals[0].gain is None  # the load cell has a calibration of its own
        run = session.runs[0]
        np.testing.assert_array_equal(run.signal_V("temperature"), 0.25)
        np.testing.assert_array_equal(session.signals[3].convert(run.signal_V("temperature")), 22.0)
        assert set(run.readings["temperature_degC"]) == {22.0}
        assert set(run.values(run.readings[0])) == {
            "force_N", "current_A", "drive_V", "temperature_degC",
        }  # fmt: skip


@pytest.mark.slow
def test_a_fourth_channel_is_recorded_with_unit_and_conversion(tmp_path):
    check_temperature(recorded(tmp_path / "s.h5"))


@pytest.mark.slow
def test_a_fourth_channel_survives_a_crash(tmp_path):
    crashed = tmp_path / "crashed.h5"
    setup = setup_of(settings(small_schedule()) | {"channels": FOUR})
    journal, translator = Journal(journal_path(crashed), setup), Translator(setup)
    for event in session_events(small_schedule()):
        for rows in translator.rows(warmed(event)):
            journal.append(rows)
    journal.sync()
    journal.close()
    recover(crashed, tmp_path / "whole.h5")
    check_temperature(tmp_path / "whole.h5")


@pytest.mark.thorough
@pytest.mark.slow
def test_a_rig_without_a_current_channel_has_no_current_in_its_readings(tmp_path):
    two = (CHANNELS[0], CHANNELS[2])
    with SessionWriter(tmp_path / "s.h5", **settings(small_schedule()) | {"channels": two}) as w:
        for event in session_events(small_schedule()):
            if isinstance(event, ev.SignalsArrived):
                block = replace(event.block, volts=event.block.volts[::2])
                event = replace(event, block=block)
            if isinstance(event, ev.ReadingTaken):
                values = {k: v for k, v in event.values.items() if k != "current_A"}
                event = replace(event, values=values)
            w.handle(event)
    with open_session(tmp_path / "s.h5") as session:
        row = session.runs[0].readings[0]
        assert set(session.runs[0].values(row)) == {"force_N", "drive_V"}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"unit": "m/s"}, "The unit 'm/s' of the channel temperature cannot be recorded"),
        ({"range_V": 0.0}, "An input range of 0.0 V cannot be recorded"),
        ({"name": "voltage", "unit": "V"}, "would be called voltage_V"),
        ({"name": "force", "unit": "degC"}, "same channel name"),
        ({"name": "force/2"}, "cannot be the name of a channel"),
    ],
)
def test_a_channel_that_a_session_cannot_hold_is_refused(change, says):
    with pytest.raises(BadInputError, match=says):
        setup_of(
            settings(small_schedule()) | {"channels": (*CHANNELS, replace(TEMPERATURE, **change))}
        )


@pytest.mark.slow
@pytest.mark.parametrize(("unit", "found"), few([("N", "N"), ("V", "V"), (None, "V")]))
def test_the_raw_force_has_the_unit_in_which_it_was_read(tmp_path, unit, found):
    resolved = {} if unit is None else {"force_channel_unit": unit}
    with SessionWriter(tmp_path / "s.h5", **settings(small_schedule()) | {"resolved": resolved}):
        pass
    with h5py.File(tmp_path / "s.h5") as file:
        signals = file["session/run_000/signals"]
        units = {name: signals[name].attrs["units"] for name in signals}
    assert units == {"force": found, "current": "V", "drive": "V", "time": "s"}

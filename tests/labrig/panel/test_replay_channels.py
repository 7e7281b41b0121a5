"""A page shows the channels that a session has, in the units its file says, and no others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from labrig.panel.replay import Recording
from labrig.session import SessionWriter
from protocols.execution import events as ev
from protocols.execution.channels import Channel
from tests.labrig.session.session_recording import (
    CHANNELS,
    session_events,
    settings,
    small_schedule,
)

LOAD_CELL = "date = 2026-11-01\nsensitivity_V_per_N = 0.15\noffset_V = 1e-4\n"
WARMTH = Channel(
    name="warmth", quantity="temperature", unit="degC", range_V=1.0, gain=100.0, offset=-3.0
)


@pytest.fixture
def other_channels(tmp_path):
    """A session whose third channel is no current but a temperature, at 0.02 times the drive."""
    path = tmp_path / "other.h5"
    schedule = small_schedule(readings=1)
    changes = {
        "channels": (CHANNELS[0], WARMTH, CHANNELS[2]),
        "texts": {"load_cell.toml": LOAD_CELL},
        "resolved": {"rig": {}},
    }
    with SessionWriter(path, **settings(schedule) | changes) as writer:
        for event in session_events(schedule):
            writer.handle(_with_warmth(event))
    return path


def _with_warmth(event):
    if isinstance(event, ev.RunStarted):
        return replace(event, channels=("force", "warmth", "drive"))
    if isinstance(event, ev.ReadingTaken):
        values = {name: value for name, value in event.values.items() if name != "current_A"}
        return replace(event, values={**values, "warmth_degC": -1.0})
    return event


@pytest.mark.slow
def test_a_session_without_a_current_is_replayed_with_the_channels_it_has(other_channels):
    recording = Recording(other_channels, "other.h5")
    try:
        rows = recording.plan["channels"]
        span = recording.spans[0]
        strip = recording.strip(0.0, span.to_s, fresh=True)
        (reading, *_) = (m for _, m in recording.timed if m["type"] == "reading")
    finally:
        recording.close()
    assert [(row["key"], row["quantity"], row["unit"]) for row in rows] == [
        ("drive_V", "voltage", "V"),
        ("force_mN", "force", "mN"),
        ("warmth_degC", "temperature", "degC"),
    ]
    assert strip.header()["rows"][1::2] == [f"{row['key']}_least" for row in rows]
    drive, warmth = strip.values[1], strip.values[5]
    assert np.ptp(drive) > 1.0
    np.testing.assert_allclose(warmth, 100.0 * 0.02 * drive - 3.0, atol=1e-4)
    assert [row["column"] in reading["values"] for row in rows] == [True] * 3

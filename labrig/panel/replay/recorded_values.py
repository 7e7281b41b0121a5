"""The signals of a recorded run in SI units, as far as its file says what its volts mean."""

from __future__ import annotations

from dataclasses import replace

from drivers.interfaces import FloatArray
from drivers.load_cell import LoadCell
from labrig.config import recorded_calibration
from labrig.session import RecordedSession, RunRecord
from protocols.execution.channels import CURRENT, FORCE, Channel


def recorded_values(session: RecordedSession, run: RunRecord) -> dict[str, FloatArray]:
    """Return each channel's values by its name; what nobody can convert is left out."""
    return {
        channel.name: _with_conversion(session, channel).convert(run.signal_V(channel.name))
        for channel in run.signals
        if is_known(session, channel)
    }


def is_known(session: RecordedSession, channel: Channel) -> bool:
    """Whether the file says what the raw samples of a channel mean."""
    whole = _with_conversion(session, channel)
    return whole.conversion is not None or whole.gain is not None


def _with_conversion(session: RecordedSession, channel: Channel) -> Channel:
    """Return the channel with what stands elsewhere in the file: calibration, and shunt."""
    if channel.name == FORCE and "load_cell.toml" in session.texts:
        text = session.texts["load_cell.toml"]
        calibration = recorded_calibration(text, "load_cell.toml", session.resolved)
        cell = LoadCell(calibration, channel.range_V, channel.raw_unit)
        return replace(channel, conversion=cell.newtons)
    sense = session.resolved.get("rig", {}).get("current_sense")
    if channel.name == CURRENT and channel.gain is None and sense:
        return replace(channel, gain=1.0 / float(sense["shunt_ohm"]))
    return channel

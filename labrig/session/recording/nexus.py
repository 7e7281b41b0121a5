"""What NeXus libraries look for in a session: its definition, program, sensors and data.

The readings of all runs stand in plain columns, which any viewer plots: the values of each channel
at a sensor of NXinstrument, and links to them beside time, voltage and position in NXdata.
Source: the application definition NXsensor_scan, https://manual.nexusformat.org.
"""

from __future__ import annotations

from typing import Any

import h5py
import numpy as np

from labrig.config.about import About
from labrig.session.format import layout
from labrig.session.format.setup import SessionSetup
from labrig.session.recording.hdf5 import (
    create_column,
    create_group,
    put_text,
    put_text_list,
    put_texts,
    set_attributes,
)

DEFINITION = "NXsensor_scan"
RELEASE = "v2024.02"  # of the NeXus definitions
NOT_STATED = "not stated"  # the definition wants a user
# NXsensor's words for quantities that have another name here. Its list is open, without force.
MEASUREMENTS = {"electric current": "current"}
_ROWS_IN_CHUNK = 256


def has_scan(setup: SessionSetup) -> bool:
    """Whether a session has the columns of all readings: since version 5, where it was recorded."""
    return (
        setup.version >= layout.NEXUS_SINCE
        and bool(setup.schedule.runs)
        and bool(setup.value_columns)
    )


def fill_nexus(file: Any, setup: SessionSetup, about: About) -> None:
    """Write definition, program, sensors, data and the group in which anybody may add anything."""
    entry = file[layout.ENTRY]
    put_text(entry, "definition", DEFINITION)
    set_attributes(entry["definition"], version=RELEASE)
    put_texts(
        entry, {"identifier_experiment": about.project, "experiment_description": about.title}
    )
    _process(file, setup)
    if not about.people:
        user = create_group(file, f"{layout.ENTRY}/user_1", "NXuser")
        put_text(user, "name", NOT_STATED)
    _sensors(file, setup)
    _data(file, setup)
    set_attributes(entry, default="data")
    create_group(file, layout.ADDITIONAL, "NXcollection")


def _process(file: Any, setup: SessionSetup) -> None:
    process = create_group(file, f"{layout.ENTRY}/process", "NXprocess")
    put_text(process, "program", "labrig")
    set_attributes(
        process["program"], version=setup.versions.get("labrig", ""), program_url="labrig"
    )


def _sensors(file: Any, setup: SessionSetup) -> None:
    instrument = create_group(file, f"{layout.ENTRY}/instrument", "NXinstrument")
    put_text(instrument, "name", "actuator rig")
    environment = create_group(file, layout.ENVIRONMENT, "NXenvironment")
    put_text(environment, "measurement_sensors", ", ".join(setup.value_columns))
    put_text(environment, "independent_controllers", "voltage_V, position_m")
    for channel in setup.signals:
        path = f"{layout.ENVIRONMENT}/{channel.column}"
        sensor = create_group(file, path, "NXsensor")
        put_text(sensor, "name", channel.name)
        put_text(sensor, "measurement", MEASUREMENTS.get(channel.quantity, channel.quantity))
        create_column(sensor, "value", "<f8", chunk=_ROWS_IN_CHUNK, units=channel.unit)


def _data(file: Any, setup: SessionSetup) -> None:
    first, *others = setup.value_columns
    data = create_group(file, layout.DATA, "NXdata")
    set_attributes(data, signal=first, title="Readings of all runs")
    put_text_list(data, "axes", ["time_s"])
    put_text_list(data, "auxiliary_signals", [*others, "voltage_V"])
    for name, (kind, units) in layout.SCAN_COLUMNS.items():
        comment = layout.SCAN_COMMENTS.get(name, "")
        create_column(data, name, kind, chunk=_ROWS_IN_CHUNK, units=units, comment=comment)
    for column in setup.value_columns:
        data[column] = h5py.SoftLink(layout.sensor_path(column))


def scan_columns(setup: SessionSetup) -> dict[str, np.dtype[Any]]:
    """Return the type of each column of all readings, by its path."""
    own = {
        layout.scan_path(name): np.dtype(kind) for name, (kind, _) in layout.SCAN_COLUMNS.items()
    }
    return own | {layout.sensor_path(name): np.dtype("<f8") for name in setup.value_columns}

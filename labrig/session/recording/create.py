"""Makes the empty session file, with all that will ever be in it while it is written.

A file that others read while it grows takes no new groups, datasets or attributes, so everything
is there from the beginning: the schedule says what will come.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from labrig.config.about import About, recorded_about
from labrig.config.load_cell import raw_force_unit
from labrig.serialise import to_plain
from labrig.session.format import layout
from labrig.session.format.channels import channel_rows
from labrig.session.format.checksums import covered
from labrig.session.format.extras import extras_of, without_extras
from labrig.session.format.layout import Array
from labrig.session.format.setup import DEVICES_SINCE, SessionSetup
from labrig.session.recording.hdf5 import (
    create_column,
    create_group,
    create_table,
    put_column_units,
    put_text,
    put_text_list,
    put_texts,
    set_attributes,
)
from labrig.session.recording.nexus import fill_nexus, has_scan
from protocols import run_to_dict, schedule_to_dict
from protocols.execution.channels import FORCE
from protocols.execution.events import Outcome, OutputState
from protocols.planning.schedule import PlannedRun

# Fast, and good enough for camera noise: 3 ms and about half of the size for a 640 x 480 frame.
FRAME_COMPRESSION = 1


def create_file(path: Path, setup: SessionSetup) -> None:
    """Write a session file without a single event in it. Raises FileExistsError, OSError."""
    with h5py.File(path, "x", libver=layout.LIBVER) as file:
        fill_file(file, setup)


def fill_file(file: Any, setup: SessionSetup) -> None:
    """Write it into a file that is open and empty."""
    set_attributes(file, labrig_format=setup.version)  # which decides how texts are stored
    set_attributes(file, NX_class="NXroot", default="session")
    entry = create_group(file, layout.ENTRY, "NXentry")
    _status(entry, setup)
    _setup_group(file, setup)
    about = recorded_about(setup.texts)
    _about(file, about)
    if has_scan(setup):
        fill_nexus(file, setup, about)
    elif setup.schedule.runs:
        set_attributes(entry, default="run_000")
    create_table(entry, "events", layout.EVENT_ROW, rows_in_chunk=64, comment=layout.EVENTS_COMMENT)
    for run in setup.schedule.all_runs:
        _run(file, run, setup)
    _checksum_table(file)


def _status(entry: Any, setup: SessionSetup) -> None:
    put_text(entry, "identifier", setup.identifier, 64)
    first = {"outcome": Outcome.RUNNING.value, "output_state": OutputState.UNKNOWN.value}
    for name, size in layout.STATUS_TEXTS.items():
        put_text(entry, name, first.get(name, ""), size)


def _setup_group(file: Any, setup: SessionSetup) -> None:
    group = create_group(file, layout.SETUP, "NXcollection")
    put_text(group, "schedule", json.dumps(schedule_to_dict(without_extras(setup.schedule))))
    extras = extras_of(setup.schedule)
    if extras:
        put_text(group, "extras", json.dumps(extras))
    put_text(group, "resolved", json.dumps(dict(setup.resolved)))
    for name, texts in (("texts", setup.texts), ("versions", setup.versions)):
        folder = create_group(file, f"{layout.SETUP}/{name}", "NXcollection")
        for key, text in texts.items():
            put_text(folder, key, text)
    group.create_dataset("signals", data=channel_rows(setup.signals, setup.version))
    group.create_dataset("rate_hz", data=np.float64(setup.rate_hz))
    group.create_dataset("simulated", data=np.bool_(setup.simulated))
    if setup.version >= DEVICES_SINCE:
        put_text(group, "devices", json.dumps(to_plain(setup.devices)))
    group.create_dataset("keep_all_frames", data=np.bool_(setup.keep_all_frames))
    if setup.frame_shape is not None:
        group.create_dataset("frame_shape", data=np.array(setup.frame_shape, dtype="<i4"))
        put_text(group, "frame_dtype", setup.frame_dtype)


def _about(file: Any, about: About) -> None:
    """Write what is stated of people and sample as NeXus has it; what is not stated is left out."""
    facts = {"title": about.title, "project": about.project, "license": about.licence}
    put_texts(file[layout.ENTRY], facts)
    for number, person in enumerate(about.people, 1):
        values = person.model_dump()
        values["ORCID"] = values.pop("orcid")
        put_texts(create_group(file, f"{layout.ENTRY}/user_{number}", "NXuser"), values)
    if about.sample is not None:
        sample = about.sample
        group = create_group(file, f"{layout.ENTRY}/sample", "NXsample")
        values = sample.model_dump(include={"material", "batch", "preparation"})
        values |= {"name": sample.identity, "description": sample.notes}
        values["preparation_date"] = "" if sample.made is None else sample.made.isoformat()
        put_texts(group, values)


def _run(file: Any, run: PlannedRun, setup: SessionSetup) -> None:
    group = create_group(file, layout.run_path(run.index), "NXsubentry")
    set_attributes(
        group,
        default="signals",
        configuration=run.configuration,
        purpose=run.purpose.value,
        position_m=np.nan if run.position_m is None else run.position_m,
        **({"extra": run.extra} if run.extra else {}),
    )
    put_text(group, "planned", json.dumps(run_to_dict(run)))
    row = _not_started(setup.version)
    # NeXus libraries fail on a table that is a scalar.
    shape = (1,) if setup.version >= layout.NEXUS_SINCE else ()
    acquisition = group.create_dataset("acquisition", data=row.reshape(shape))
    put_column_units(acquisition, {})
    create_table(group, "writes", layout.WRITE_ROW, rows_in_chunk=32)
    if run.reference:
        create_table(group, "control", layout.CONTROL_ROW, rows_in_chunk=256)
    units = {channel.column: channel.unit for channel in setup.signals}
    create_table(
        group,
        "readings",
        setup.reading_row,
        rows_in_chunk=16,
        units=units,
        comment=layout.READINGS_COMMENT,
    )
    create_table(group, "marks", layout.MARK_ROW, rows_in_chunk=8, comment=layout.MARKS_COMMENT)
    _signals(file, run, setup)
    if setup.frame_shape is not None:
        _frames(file, run, setup.frame_shape, setup)


def _not_started(version: int) -> Array:
    row = np.zeros((), dtype=layout.acquisition_row(version))
    for name, kind in row.dtype.fields.items():
        if kind[0].kind == "f":
            row[name] = np.nan
    return row


def _signals(file: Any, run: PlannedRun, setup: SessionSetup) -> None:
    group = create_group(file, f"{layout.run_path(run.index)}/signals", "NXdata")
    set_attributes(group, signal=setup.channels[0] if setup.channels else "time")
    put_text_list(group, "axes", ["time"])
    if len(setup.channels) > 1:
        put_text_list(group, "auxiliary_signals", list(setup.channels[1:]))
    chunk = layout.signal_chunk(setup.rate_hz)
    for name in (*setup.channels, "time"):
        create_column(group, name, "<f8", chunk=chunk, units=_unit_of(name, setup))


def _unit_of(name: str, setup: SessionSetup) -> str:
    """Return the unit of raw samples: volts, but for a force that a meter reports by itself."""
    if name == FORCE:
        return raw_force_unit(setup.resolved)
    return "s" if name == "time" else "V"


def _frames(file: Any, run: PlannedRun, shape: tuple[int, int], setup: SessionSetup) -> None:
    group = create_group(file, f"{layout.run_path(run.index)}/frames", "NXdata")
    set_attributes(group, signal="images")
    put_text_list(group, "axes", ["time", ".", "."])
    group.create_dataset(
        "images",
        shape=(0, *shape),
        maxshape=(None, *shape),
        chunks=(1, *shape),
        dtype=np.dtype(setup.frame_dtype),
        compression="gzip",
        compression_opts=FRAME_COMPRESSION,
    )
    for name, (kind, unit) in layout.frame_columns(setup.version).items():
        comment = layout.FRAME_COMMENTS.get(name, "")
        create_column(group, name, kind, chunk=64, units=unit, comment=comment)


def _checksum_table(file: Any) -> None:
    names = sorted(name.encode() for name in covered(file))
    rows = np.zeros(len(names), dtype=layout.CHECKSUM_ROW)
    rows["dataset"] = names
    file.create_dataset(layout.CHECKSUMS, data=rows)

"""Supplements are added to a closed session, each with a checksum of its own."""

from __future__ import annotations

import shutil

import h5py
import numpy as np
import pytest

from labrig.errors import BadInputError
from labrig.session import open_session, recover, store_measurements, verify
from labrig.session.format import layout
from labrig.session.recording.hdf5 import put_text, set_attributes
from labrig.session.supplements.store import store_supplement
from tests.labrig.session.measured import measurements
from tests.labrig.session.session_recording import record, small_schedule


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "session.h5"
    record(path, small_schedule(readings=1, positions_m=(0.005,)))
    return path


@pytest.fixture
def noted(recorded, tmp_path):
    path = shutil.copy(recorded, tmp_path / "s.h5")
    store_supplement(path, layout.NOTES, write_notes)
    return path


def write_notes(group):
    put_text(group, "text", "Ein Fleck, links.")
    photographs = group.create_group("photographs")
    photographs.create_dataset("0", data=np.arange(100, dtype=np.uint8))
    set_attributes(photographs["0"], who="A. B.")


def failed(path):
    return {check.name: check.found for check in verify(path) if not check.ok}


@pytest.mark.slow
def test_a_supplement_leaves_the_recording_and_its_checksum_as_they_were(noted, recorded):
    assert failed(noted) == {}
    with open_session(noted) as after, open_session(recorded) as before:
        assert after.checksum == before.checksum


@pytest.mark.thorough
@pytest.mark.parametrize(
    "change",
    [
        lambda notes: notes["photographs/0"].__setitem__(3, 9),
        lambda notes: notes["photographs/0"].attrs.__setitem__("who", np.bytes_(b"C. D.")),
        lambda notes: notes.attrs.__setitem__("remark", 1),
        lambda notes: notes.create_group("more"),
        lambda notes: notes.attrs.__delitem__("sha256"),
    ],
)
def test_whatever_is_changed_in_a_supplement_is_found_and_the_recording_is_whole(noted, change):
    with h5py.File(noted, "r+") as file:
        change(file[layout.NOTES])
    assert failed(noted) == {"notes": "changed since they were stored"}


@pytest.mark.slow
def test_a_supplement_survives_the_analysis_and_the_analysis_it(noted):
    store_measurements(noted, measurements())
    store_supplement(noted, layout.NOTES, lambda group: put_text(group, "text", "another"))
    with h5py.File(noted) as file:
        assert file[layout.NOTES]["text"][()] == b"another"
        assert layout.DERIVED in file
    assert failed(noted) == {}


@pytest.mark.slow
def test_a_supplement_that_fails_leaves_the_session_as_it_was(noted):
    before = noted.read_bytes()

    def fail(group):
        put_text(group, "text", "half")
        raise BadInputError("no")

    with pytest.raises(BadInputError):
        store_supplement(noted, layout.NOTES, fail)
    assert noted.read_bytes() == before
    assert [path.name for path in noted.parent.iterdir()] == ["s.h5"]


@pytest.mark.thorough
@pytest.mark.slow
def test_recover_keeps_the_supplements_that_are_whole(noted, tmp_path):
    store_measurements(noted, measurements())
    with h5py.File(noted, "r+") as file:
        file["session/outcome"][()] = b"running"  # the file looks as if its writer had been killed
        file["session/derived/conditions"][0] = file["session/derived/conditions"][1]
    report = recover(noted, tmp_path / "whole.h5")
    assert any(layout.DERIVED in note for note in report.notes)
    with h5py.File(tmp_path / "whole.h5") as file:
        assert layout.DERIVED not in file
        assert file[layout.NOTES]["photographs/0"].attrs["who"] == "A. B."
    assert failed(tmp_path / "whole.h5") == {}

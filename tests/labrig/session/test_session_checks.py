"""Verification, comparison, and files that are no sessions."""

from __future__ import annotations

import random
import shutil

import h5py
import numpy as np
import pytest

from labrig.errors import BadInputError, LabrigError
from labrig.session import compare_sessions, open_session, verify
from tests.labrig.session.session_recording import record, small_schedule


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "session.h5"
    record(path, small_schedule())
    return path


@pytest.fixture
def session(recorded, tmp_path):
    return shutil.copy(recorded, tmp_path / "s.h5")


def failed(path):
    return {check.name: check.found for check in verify(path) if not check.ok}


@pytest.mark.slow
def test_a_whole_session_passes_every_check(recorded):
    checks = verify(recorded)
    assert all(check.ok for check in checks)
    assert {"opens", "outcome", "checksums", "run 2: readings"} <= {check.name for check in checks}


@pytest.mark.slow
def test_one_changed_sample_is_found(session):
    with h5py.File(session, "r+") as file:
        file["session/run_001/signals/force"][1234] += 1e-9
    assert list(failed(session)) == ["checksums"]
    assert "/session/run_001/signals/force" in failed(session)["checksums"]


@pytest.mark.slow
def test_one_flipped_bit_in_a_frame_is_found(session):
    with h5py.File(session) as file:
        at = file["session/run_000/frames/images"].id.get_chunk_info(2)
    raw = bytearray(session.read_bytes())
    raw[at.byte_offset + at.size // 2] ^= 16
    session.write_bytes(raw)
    assert "/session/run_000/frames/images" in failed(session)["checksums"]


@pytest.mark.slow
def test_a_reading_that_is_missing_is_found(session):
    with h5py.File(session, "r+") as file:
        file["session/run_001/readings"].resize(5, axis=0)
    assert failed(session)["run 2: readings"] == "5 of 8"


@pytest.mark.thorough
@pytest.mark.slow
def test_two_recordings_of_the_same_run_are_equal_however_the_samples_came(recorded, tmp_path):
    record(tmp_path / "b.h5", small_schedule(), block=173)
    assert compare_sessions(recorded, tmp_path / "b.h5") == []
    with open_session(recorded) as a, open_session(tmp_path / "b.h5") as b:
        assert a.identifier != b.identifier
        assert a.checksum == b.checksum


@pytest.mark.thorough
@pytest.mark.slow
def test_comparison_names_what_differs_and_where(session, recorded):
    with h5py.File(session, "r+") as file:
        file["session/run_001/signals/force"][1234] += 1e-9
        del file["session/run_000/marks"]
        file["session/reason"][()] = b"otherwise"
    assert compare_sessions(session, recorded) == [
        f"/session/run_000/marks is only in {recorded}.",
        "/session/reason differs: its value.",
        "/session/run_001/signals/force differs: first in row 1234.",
    ]


def write(path, content):
    path.write_bytes(content)


def plain_hdf5(path):
    with h5py.File(path, "w") as file:
        file["x"] = np.arange(3)


def edited(change):
    def make(path, recorded):
        shutil.copy(recorded, path)
        with h5py.File(path, "r+") as file:
            change(file)

    return make


def huge(file):
    file.create_dataset(
        "session/huge", shape=(10**12,), chunks=(1024,), dtype="f8", compression="gzip"
    )


def broken_schedule(file):
    old = file["session/setup/schedule"][()]
    file["session/setup/schedule"][()] = old.replace(b'"runs"', b'"rums"')


def stated(name, text):
    def change(file):
        del file[f"session/setup/{name}"]
        file[f"session/setup/{name}"] = np.bytes_(text)

    return change


BAD_FILES = {
    "resolved is no table": edited(stated("resolved", b"[]")),
    "a sample rate of nan Hz cannot": edited(
        lambda file: file["session/setup/rate_hz"].__setitem__((), np.nan)
    ),
    "there is no such file": lambda path, _: None,
    "a folder": lambda path, _: path.mkdir(),
    "this is an empty file": lambda path, _: write(path, b""),
    "is not an HDF5 file": lambda path, _: write(path, b"configuration,position_mm\n"),
    "no labrig session": lambda path, _: plain_hdf5(path),
    "truncated": lambda path, recorded: write(path, recorded.read_bytes()[:-5000]),
    "has format 7": edited(lambda file: file.attrs.__setitem__("labrig_format", 7)),
    "is a link": edited(lambda file: file.__setitem__("session/x", h5py.SoftLink("/session"))),
    "/session/away is a link": edited(
        lambda file: file.__setitem__("session/away", h5py.ExternalLink("a.h5", "/"))
    ),
    "has a type": edited(lambda file: file.create_dataset("session/v", data=["a", "bc"])),
    "more content than the file can hold": edited(huge),
    "setup/signals is missing": edited(lambda file: file.__delitem__("session/setup/signals")),
    "what was planned cannot be read": edited(broken_schedule),
}


@pytest.mark.parametrize("said", BAD_FILES)
def test_what_is_no_session_is_refused_in_a_sentence(said, recorded, tmp_path):
    path = tmp_path / "bad.h5"
    BAD_FILES[said](path, recorded)
    with pytest.raises(BadInputError) as caught:
        open_session(path).close()
    assert said in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert [check.ok for check in verify(path)][-1] is False


def test_a_signal_that_was_cut_is_a_sentence(session):
    with h5py.File(session, "r+") as file:
        whole = file["session/run_001/signals/force"][:100]
        del file["session/run_001/signals/force"]
        file["session/run_001/signals/force"] = whole
    with (
        open_session(session) as found,
        pytest.raises(BadInputError, match=r"signals/force has 100 samples, signals/time has \d+"),
    ):
        found.run(1).signal_V("force")


def test_a_damaged_signal_is_a_sentence_too(session):
    with h5py.File(session) as file:
        at = file["session/run_000/signals/force"].id.get_chunk_info(0)
    raw = bytearray(session.read_bytes())
    raw[at.byte_offset : at.byte_offset + at.size] = b"\xff" * at.size
    session.write_bytes(raw)
    with (
        open_session(session) as opened,
        pytest.raises(BadInputError, match=r"signals/force is damaged"),
    ):
        opened.runs[0].signal_V("force")


def what_is_said(path):
    """Read all of a session; the sentence of the error, or nothing."""
    try:
        with open_session(path) as session:
            for run in session.runs:
                assert len(run.readings) == len(run.planned.readings)
                run.signal_V("force")
                run.image(0)
            assert session.events
    except LabrigError as error:
        return str(error)
    return ""


@pytest.mark.slow
@pytest.mark.parametrize(
    "seeds", [range(10), pytest.param(range(10, 60), marks=pytest.mark.thorough)], ids=str
)
def test_no_damage_ends_in_anything_but_a_sentence(seeds, recorded, tmp_path):
    raw = recorded.read_bytes()
    refused = 0
    for seed in seeds:
        dice = random.Random(seed)
        damaged = bytearray(raw)
        at, length = dice.randrange(48, len(raw)), dice.choice([1, 64, 4096])
        damaged[at : at + length] = dice.randbytes(len(damaged[at : at + length]))
        path = tmp_path / f"{seed}.h5"
        path.write_bytes(damaged)
        whole, said = all(check.ok for check in verify(path)), what_is_said(path)
        assert not said or (str(path) in said and not whole)
        refused += bool(said)
    assert refused > len(seeds) / 6

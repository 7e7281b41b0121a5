"""A diagnosis that is kept in its session comes back as it was, and goes with the measurements."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from labrig.errors import BadInputError
from labrig.report.data.kept_diagnosis import keep_diagnosis, kept_diagnosis
from labrig.serialise import SerialiseError, from_plain, to_plain
from labrig.session import drop_measurements, load_measurements, store_measurements, verify
from model.discrepancy.verdict.result import Diagnosis
from tests.cases import few
from tests.labrig.diagnose.made import ALL, found
from tests.labrig.report_data import measure, session


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    return session(tmp_path_factory.mktemp("kept") / "made.h5", measure("long"))


@pytest.fixture
def recorded(once, tmp_path):
    """A copy of a session that was recorded once."""
    return Path(shutil.copy(once, tmp_path / "made.h5"))


@pytest.mark.parametrize("make", few(ALL))
def test_a_diagnosis_survives_json_without_loss(make):
    one = make()
    again = from_plain(Diagnosis, json.loads(json.dumps(to_plain(one), allow_nan=False)))
    assert to_plain(replace(again, model=one.model)) == to_plain(one)
    assert again.to_json() == one.to_json()
    np.testing.assert_array_equal(again.rows[3].before_off_m, one.rows[3].before_off_m)
    assert again.model.effects == one.model.effects


def test_what_an_older_version_did_not_write_takes_its_default():
    plain = to_plain(found())
    del plain["seconds"]
    assert from_plain(Diagnosis, plain).seconds == 0.0
    del plain["verdict"]
    with pytest.raises(SerialiseError, match="'verdict' is missing"):
        from_plain(Diagnosis, plain)


@pytest.mark.slow
def test_it_is_kept_beside_the_measurements_and_changes_nothing_else(recorded):
    before = load_measurements(recorded)
    assert kept_diagnosis(recorded) is None
    keep_diagnosis(recorded, found())
    keep_diagnosis(recorded, replace(found(), seconds=7.0))
    kept = kept_diagnosis(recorded)
    assert kept is not None
    assert kept.seconds == 7.0
    assert len(load_measurements(recorded).conditions) == len(before.conditions)
    assert all(check.ok for check in verify(recorded)), [c for c in verify(recorded) if not c.ok]


@pytest.mark.slow
def test_it_goes_with_the_measurements_it_was_made_from(recorded):
    path = recorded
    keep_diagnosis(path, found())
    store_measurements(path, load_measurements(path))
    assert kept_diagnosis(path) is None
    keep_diagnosis(path, found())
    drop_measurements(path)
    assert kept_diagnosis(path) is None


@pytest.mark.slow
@pytest.mark.parametrize("content", few([b"{", b"[]", b'{"verdict": 3}', b"\xff\xff"]))
def test_one_that_cannot_be_read_says_what_to_do(recorded, content):
    path = recorded
    keep_diagnosis(path, found())
    with h5py.File(path, "r+") as file:
        del file["/session/derived/diagnosis"]
        file["/session/derived/diagnosis"] = np.frombuffer(content, dtype=np.uint8)
    with pytest.raises(BadInputError, match="diagnosis"):
        kept_diagnosis(path)

"""What a batch is given: files, folders and patterns."""

from __future__ import annotations

from labrig.batch.contract import InputKind
from labrig.batch.inputs import found_inputs


def test_every_name_that_a_session_may_have_is_worked_on(tmp_path):
    for name in ("a.h5", "b.hdf5", "c.nxs", "D.H5", "e.csv"):
        (tmp_path / name).write_bytes(b"the names alone count")
    whole = found_inputs([str(tmp_path)], {InputKind.SESSION}, tmp_path)
    by_pattern = found_inputs([str(tmp_path / "*.*")], {InputKind.SESSION}, tmp_path)
    for found in (whole, by_pattern):
        assert [one.name for one in found.inputs] == ["D.H5", "a.h5", "b.hdf5", "c.nxs"]
    assert by_pattern.left_out == 1

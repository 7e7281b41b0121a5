"""Rows are kept as they end; what a crash leaves of the last one is cut off."""

from __future__ import annotations

import json

import pytest

from labrig.batch.row_file import row_file
from labrig.batch.rows import LastRows, PieceOutcome, Row, rows_in
from labrig.errors import BadInputError


def row(name, **more):
    return Row(**({"name": name, "key": "k", "outcome": PieceOutcome.DONE} | more))


def test_rows_come_back_as_they_were(tmp_path):
    path = tmp_path / "rows.jsonl"
    rows = [
        row("a.h5", stamp=((1, 2), (3, 4)), columns={"B": 1.5, "effects": ["x"]}, content="c"),
        row("b µ.h5", outcome=PieceOutcome.FAULT, sentence='is "no" session.\n', attempts=3),
    ]
    with row_file(path) as file:
        file.append(rows[:1])
        file.append(rows[1:])
    assert list(rows_in(path)) == rows
    assert all(json.loads(line) for line in path.read_bytes().splitlines())


@pytest.mark.parametrize("torn", [b"{", b'{"name": "c", ', b"\xff\xfe", b"x" * 200_000])
def test_a_torn_last_line_is_cut_off_and_the_next_row_is_whole(tmp_path, torn):
    path = tmp_path / "rows.jsonl"
    with row_file(path) as file:
        file.append([row("a"), row("b")])
    with path.open("ab") as file:
        file.write(torn)
    assert [one.name for one in rows_in(path)] == ["a", "b"]
    with row_file(path) as file:
        file.append([row("c")])
    assert [one.name for one in rows_in(path)] == ["a", "b", "c"]
    assert len(path.read_bytes().splitlines()) == 3


def test_every_cut_of_the_file_leaves_the_rows_before_it(tmp_path):
    path = tmp_path / "rows.jsonl"
    whole = b"".join(row(name).line() for name in "ab")
    first = len(row("a").line())
    for end in {0, 1, *range(7, len(whole), 41), first - 1, first, len(whole) - 1, len(whole)}:
        path.write_bytes(whole[:end])
        with row_file(path) as file:
            file.append([row("c")])
        names = [one.name for one in rows_in(path)]
        assert names == [*"ab"[: (end >= first) + (end == len(whole))], "c"]


def test_damaged_lines_and_those_of_other_versions_are_passed_over(tmp_path):
    path = tmp_path / "rows.jsonl"
    lines = [b"[]", b'{"version": 99}', b'{"version": 1, "name": 3}', b"", b"null"]
    path.write_bytes(row("a").line() + b"\n".join(lines) + b"\n" + row("b").line())
    assert [one.name for one in rows_in(path)] == ["a", "b"]


def test_the_last_row_of_a_name_counts_and_names_keep_their_order(tmp_path):
    path = tmp_path / "rows.jsonl"
    with row_file(path) as file:
        file.append([row("b", digest="1"), row("a"), row("b", digest="2"), row("other")])
    rows = LastRows(path, ["a", "missing", "b"])
    assert [(one.name, one.digest) for one in rows] == [("a", ""), ("b", "2")]
    assert len(rows) == 2


@pytest.mark.slow
def test_two_programs_do_not_write_to_the_same_rows(tmp_path):
    path = tmp_path / "rows.jsonl"
    with row_file(path), pytest.raises(BadInputError, match="another program"), row_file(path):
        pass

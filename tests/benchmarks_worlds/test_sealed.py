"""The sealed worlds are those that were sealed."""

from __future__ import annotations

import tomllib

import pytest

from benchmarks.worlds.sealed import FILE, check, open_worlds

TABLE = tomllib.loads(FILE.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", TABLE["sealed"])
def test_a_sealed_world_has_not_changed_since_it_was_sealed(name: str) -> None:
    for seed in TABLE["report"]["seeds"]:
        check(name, seed)


def test_no_sealed_world_is_open() -> None:
    assert {"collocation", "legendre", "magnus", "relaxation", "splines"} <= set(TABLE["sealed"])
    assert not set(TABLE["sealed"]) & set(open_worlds())

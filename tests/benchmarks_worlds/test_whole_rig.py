"""Worlds of the whole rig: they can be made, and answers are judged as the page says."""

from __future__ import annotations

from importlib.resources import files

import pytest
import tomlkit

from benchmarks.whole_rig.__main__ import (
    ALONE,
    AMONG,
    ELSEWHERE,
    IN_THE_SET,
    NOTHING,
    UNKNOWN,
    WRONG,
    Answer,
    Case,
    cases,
    judged,
    merged,
    table,
)
from labrig.session.tables.drive_table import load_protocol
from model.effects import catalogue
from model.locations import locations
from sim_hardware.world import load_world

PROTOCOL = files("labrig.config") / "template_files" / "protocol.toml"
TILT = Case(hidden="a", world={}, names=("clamp_angle",))
DENT = Case(hidden="b", world={}, locations=("camera",))


def test_every_world_can_be_made_and_what_it_hides_has_a_name_or_a_location(tmp_path):
    seen = set()
    for number, one in enumerate(cases()):
        path = tmp_path / f"{number}.toml"
        path.write_text(tomlkit.dumps({"seed": 1, **one.world}), encoding="utf-8")
        seen.add((load_world(path).model_dump_json(), tomlkit.dumps(one.protocol)))
        assert set(one.names) <= set(catalogue())
        assert set(one.locations) <= set(locations())
        assert not (one.names and one.locations)
    assert len(seen) == len(cases())


def test_every_protocol_can_be_read(tmp_path):
    for one in cases():
        usual = tomlkit.parse(PROTOCOL.read_text(encoding="utf-8")).unwrap()
        path = tmp_path / "protocol.toml"
        path.write_text(tomlkit.dumps(merged(usual, one.protocol)), encoding="utf-8")
        load_protocol(path)


def test_a_world_has_what_the_clean_one_has_but_for_what_it_says():
    clean = {"eibm": {"decay_mm": 0.0, "build_up_s": 0.1}, "water": {"a": 1}}
    assert merged(clean, {"eibm": {"build_up_s": 0.2}, "seed": 3}) == {
        "eibm": {"decay_mm": 0.0, "build_up_s": 0.2}, "water": {"a": 1}, "seed": 3,
    }  # fmt: skip


def answer(*named: str, unknown: str = "", reported_set: tuple[str, ...] = ()) -> Answer:
    return Answer(hidden="a", seed=1, named=named, unknown=unknown, reported_set=reported_set)


@pytest.mark.parametrize(
    ("case", "given", "found"),
    [
        (TILT, answer("clamp_angle"), ALONE),
        (TILT, answer("clamp_angle", "gravity"), AMONG),
        (TILT, answer("clamp_angle", unknown="time"), AMONG),
        (TILT, answer("gravity", reported_set=("clamp_angle",)), WRONG),
        (TILT, answer(reported_set=("clamp_angle",)), IN_THE_SET),
        (TILT, answer(unknown="camera"), ELSEWHERE),
        (TILT, answer(), NOTHING),
        (DENT, answer(unknown="camera"), UNKNOWN),
        (DENT, answer(unknown="eibm"), ELSEWHERE),
        (DENT, answer("gravity", unknown="camera"), WRONG),
        (DENT, answer(), NOTHING),
    ],
)
def test_answers_are_judged(case, given, found):
    assert judged(case, given) == found


def test_the_table_counts_each_kind_by_itself():
    given = [
        Answer(hidden="nothing", seed=1),
        Answer(hidden="turned clamp", seed=1, named=("clamp_angle",), confidence=0.9),
        Answer(hidden="turned camera", seed=1, error="no such rig"),
    ]
    lines = "\n".join(table(given))
    assert f"nothing | 1 | {NOTHING}" in lines
    assert f"turned clamp | 1 | {ALONE} | 0.90" in lines
    assert "in the catalogue, n 2;" in lines
    assert "error | 1 |" in lines

"""B and EIBM of worlds: true values, and which intervals count."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.hidden_effects.records import Hid, Name, Record
from benchmarks.worlds.base_parameters import beside_truth, by_quantity, held, true_values
from benchmarks.worlds.cases import CATALOGUE_FORM, MIXED, made, tasks
from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators._shooting_specimen import specimens
from benchmarks.worlds.generators.shooting import WORLD
from benchmarks.worlds.registry import world
from benchmarks.worlds.table import rows
from model.parameter import Parameter

HID = Hid("clamp_angle", "tilted", 1.0, "position", [], None, {}, as_in_catalogue=True, d=20.0,
          alone=20.0)  # fmt: skip
RECORD = Record(
    key="chain:single:0:1/diagnose", family="single", code="", truth=[HID], near={}, left={},
    left_tolerant={}, force_gap_mN=0.0, curve_gap_mm=0.0, conditions="",
    named=[Name("clamp_angle", 0.99, [], 0.0, {})],
    base={"long: B_Nm2": [1.0, 0.9, 1.1, 1.05], "long: EIBM +2 V": [1.0, 0.9, 1.1, 1.2]},
)  # fmt: skip


def test_a_session_without_noise_tells_b_and_the_eibm_of_a_world() -> None:
    found, made = true_values(WORLD, 5, Design(remounts=1)), specimens(5)
    assert len(found) == 6
    for name, one in made.items():
        assert found[f"{name}: B_Nm2"] == pytest.approx(one.strip.stiffness_Nm2, rel=2e-4)
        for volts in (2.0, -2.0):
            true = float(one.eibm_Nm(volts))
            assert found[f"{name}: EIBM {volts:+g} V"] == pytest.approx(true, rel=2e-4)


def test_what_is_said_is_put_beside_what_is_true() -> None:
    B = Parameter(value=2.0, sigma=0.1, unit="N m^2")
    told = beside_truth({"long": {"B_Nm2": B, "other": B}}, {"long: B_Nm2": 2.1})
    ((value, low, high, true),) = told.values()
    assert (value, true) == (2.0, 2.1)
    assert (low, high) == pytest.approx((2.0 - 0.1645, 2.0 + 0.1645), abs=1e-3)


def test_intervals_count_where_the_verdict_is_right_and_the_form_the_catalogue_s() -> None:
    assert [one.ok for one in held([RECORD])] == [True, False]
    assert not held([replace(RECORD, truth=[replace(HID, as_in_catalogue=False)])])
    assert not held([replace(RECORD, named=[Name("gravity", 0.99, [], 0.0, {})])])
    nothing = replace(RECORD, family="nothing", truth=[], named=[])
    assert len(held([nothing])) == 2
    assert not held([replace(nothing, named=RECORD.named)])
    assert by_quantity([RECORD, nothing]) == [("B_Nm2", "2/2"), ("EIBM +2 V", "0/2")]


def test_intervals_of_one_case_go_together() -> None:
    all_right = replace(RECORD, key="b", base={"long: B_Nm2": [1.0, 0.9, 1.1, 1.05]})
    row = next(r for r in rows([RECORD, all_right]) if "B or an EIBM" in r.what)
    assert (row.value, row.count) == ("66.7%", 3)
    # off by -1/3 and by +1/3: 1.645 * sqrt(2) / 9
    assert row.interval == "40.8% - 92.5% (2 cases)"


def test_a_family_has_the_catalogue_s_own_forms_alone() -> None:
    kinds = world("chain").kinds
    found = tasks("chain", 30, 4, [CATALOGUE_FORM])
    assert len(found) == 30
    assert all(kinds[t.hidden[0][0]].own_form for t in found)
    assert CATALOGUE_FORM not in {t.family for t in tasks("chain", 30, 4)}


def test_a_family_has_an_effect_beside_what_no_catalogue_has() -> None:
    kinds = world("chain").kinds
    found = tasks("chain", 30, 4, [MIXED])
    known = [[kinds[kind].known_as is not None for kind, _ in task.hidden] for task in found]
    assert known == [[True, False]] * 30
    assert len({task.hidden[0][0] for task in found}) > 10
    assert MIXED not in {t.family for t in tasks("chain", 30, 4)}


@pytest.mark.slow
@pytest.mark.thorough
def test_a_mixed_case_is_measured_as_a_whole_and_each_part_by_itself() -> None:
    (task,) = tasks("chain", 1, 4, [MIXED])
    one = made(replace(task, hidden=(("heavy", 20.0), ("swinging_zero", 40.0))))
    assert one.visible.d[0] == pytest.approx(20.0, rel=0.3)
    assert one.visible.left_tolerant["gravity"] > 0.8  # of what swings: the weight is no part of it
    assert min(one.visible.near.values()) > 4.0  # of the weight

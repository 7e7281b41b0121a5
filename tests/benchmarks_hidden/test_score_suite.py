"""A small suite: a few sessions made, diagnosed and scored as the benchmark does with hundreds."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import pytest

from benchmarks.hidden_effects import Case, Hiding, case, hidden_session
from benchmarks.hidden_effects.baselines import answers
from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.run import made, record, run
from benchmarks.hidden_effects.score import clear, exactly, is_unknown, means_right, place_right
from benchmarks.hidden_effects.suite import Task
from benchmarks.hidden_effects.visible import Yardstick
from tests.model.discrepancy.sessions import without_first_pulses

pytestmark = pytest.mark.thorough


def task(name: str, hidden: Case, **other: Any) -> Task:
    return Task(f"{name}:0:0", name, hidden, **other)


NOTHING = task("nothing", Case(seed=31))
WILD = task("nothing", Case(seed=32, scatter=2.0, correlated=True, outlier=True))
OTHER_FORM = task("other_form", case("nonuniform_eibm", "cosh", 0.12, seed=33))
REALISTIC = task("realistic", case("nonlinear_stiffness", "early", 0.1, seed=34))
MEANS = task("means_only", case("position_error", size=0.5, seed=35, streams="means"))
PAIR = task(
    "pair", Case((Hiding("gravity", size=1.2e-3), Hiding("position_error", size=0.4)), seed=36)
)
OUTSIDE = task("outside", case("local_rest_curvature", size=4.0, seed=37))
COMPLIANCE = "load_cell_compliance"
EXCLUDED = task("excluded", case(COMPLIANCE, size=0.01, seed=38), exclude=(COMPLIANCE,))


@cache
def answered(asked: Task) -> Record:
    return record(asked)


def nothing_named(r: Record) -> bool:
    return not r.said and r.unknown is None


def exactly_and_clear(r: Record) -> bool:
    return exactly(r) and clear(r)


def unknown_in_its_place(r: Record) -> bool:
    return is_unknown(r) and place_right(r)


def unknown_in_its_slot(r: Record) -> bool:
    assert COMPLIANCE not in r.left
    return r.unknown is not None and r.unknown.slot in r.truth[0].accepted_slots


@pytest.mark.parametrize(
    ("asked", "right"),
    [
        (NOTHING, nothing_named),
        pytest.param(WILD, nothing_named),
        pytest.param(OTHER_FORM, exactly_and_clear),
        pytest.param(REALISTIC, exactly_and_clear),
        (MEANS, means_right),
        pytest.param(PAIR, exactly_and_clear),
        pytest.param(OUTSIDE, unknown_in_its_place),
        pytest.param(EXCLUDED, unknown_in_its_slot),
    ],
    ids=lambda x: x.key if isinstance(x, Task) else "",
)
def test_a_session_is_answered_rightly(asked: Task, right: Callable[[Record], bool]) -> None:
    found = answered(asked)
    assert not found.error
    assert right(found), found


@cache
def yardstick() -> Yardstick:
    return Yardstick(hidden_session(case(seed=5)).measurements)


def test_d_grows_with_the_size_and_an_effect_is_its_own_best_description() -> None:
    one, two = (
        hidden_session(case(COMPLIANCE, size=s, seed=5)).measurements for s in (0.002, 0.004)
    )
    assert yardstick().length(hidden_session(case(seed=5)).measurements) == pytest.approx(
        0.0, abs=1e-6
    )
    assert yardstick().length(two) == pytest.approx(2.0 * yardstick().length(one), rel=0.05)
    seen = yardstick().visible(two, [two], [COMPLIANCE])
    assert seen.left[COMPLIANCE] < 0.01
    assert min(v for n, v in seen.left.items() if n != COMPLIANCE) > 0.2
    assert seen.d == seen.alone


def test_another_effect_is_as_far_away_as_it_explains_less_than_the_right_entry() -> None:
    """A form that is not the catalogue's is some way off every entry."""
    odd = hidden_session(case("nonuniform_eibm", "root", seed=5)).measurements
    seen = yardstick().visible(odd, [odd], ["nonuniform_eibm"])
    (d,) = seen.d
    own, other = (d**2 * seen.left[name] for name in ("nonuniform_eibm", "nonuniform_stiffness"))
    assert own > 1.0
    assert seen.near["nonuniform_stiffness"] ** 2 == pytest.approx(other - own)
    assert "nonuniform_eibm" not in seen.near
    # what comes nearer than the right entry cannot be told from it
    taken = yardstick().visible(odd, [odd], ["gravity"])
    assert taken.near["nonuniform_eibm"] == 0.0


def test_what_the_base_model_can_take_up_is_not_there_to_be_seen() -> None:
    lost = case("back_relaxation", "single", 0.25, seed=5, streams="means")  # a quarter of it
    weaker, bare = (hidden_session(c).measurements for c in (lost, case(seed=5, streams="means")))
    assert Yardstick(bare).length(weaker) > 8.0  # the first pulse has lost less
    weaker, bare = (without_first_pulses(m) for m in (weaker, bare))
    assert Yardstick(bare).length(weaker) < 4.0


def test_sizes_are_found_for_a_wanted_d_and_the_pool_gives_the_same_as_one_process() -> None:
    asked = task("own_form", case("position_error", seed=9), sizing="d", wanted=(20.0,))
    one = made(asked)
    assert one.visible.d[0] == pytest.approx(20.0, rel=0.15)
    assert one.visible.alone == one.visible.d
    (pooled,) = run([NOTHING], jobs=2)
    alone = answered(NOTHING)
    names, gains = zip(*alone.ranking, strict=True)
    assert [name for name, _ in pooled.ranking] == [*names]
    # processes that are many give linear algebra one thread: the last digits may differ
    assert [gain for _, gain in pooled.ranking] == pytest.approx([*gains], rel=1e-6)
    assert pooled.said == alone.said


def test_simpler_methods_name_what_is_not_there_or_name_nothing() -> None:
    found = answers(made(NOTHING))
    assert found["repeats_bic"]["named"]  # repeats do not hold the scatter of set-ups
    assert "named" not in found["gp"]
    seen = answers(made(task("x", case(COMPLIANCE, size=0.01, seed=5))))
    assert seen["fixed_forms"]["named"] == [COMPLIANCE]
    assert COMPLIANCE in seen["stlsq"]["named"]  # type: ignore[operator]
    assert answers(made(OTHER_FORM))["gp"]["closed"] > 0.5  # type: ignore[operator]

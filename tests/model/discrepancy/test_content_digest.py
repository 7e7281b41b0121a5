"""Equal content has the same digest, and any other content another one."""

from __future__ import annotations

from dataclasses import dataclass, field
from datetime import date
from functools import cached_property

import numpy as np
import pytest

from model.discrepancy.data_checks.content_digest import content_digest


@dataclass(frozen=True)
class Held:
    array: np.ndarray
    by_name: dict[str, float] = field(default_factory=dict)

    @cached_property
    def total(self) -> float:
        return float(self.array.sum())


class Plain:
    def __init__(self, value: object) -> None:
        self.value = value


def made(**changes: float) -> Held:
    return Held(np.array([1.0, 2.0]), {"a": 1.0} | changes)


def test_it_asks_what_is_held_and_not_by_which_object():
    one, other = made(), made()
    assert one.total == 3.0  # kept in the one alone
    assert content_digest(one, [Plain(one)]) == content_digest(other, [Plain(other)])


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (made(), made(a=2.0)),
        (made(), made(b=2.0)),
        (np.zeros(2), np.zeros((2, 1))),
        (np.zeros(2), np.zeros(2, dtype=int)),
        (1, 1.0),
        (1, True),
        ("1", 1),
        (["ab", "c"], ["a", "bc"]),
        ([["a"], "b"], [["a", "b"]]),
        (Plain(1), Plain(2)),
        (None, "None"),
        (np.mean, np.sum),
        ({1, 2}, {1, 3}),
        (date(2026, 1, 1), date(2026, 1, 2)),
    ],
)
def test_other_content_has_another_one(one, other):
    assert content_digest(one) != content_digest(other)
    assert content_digest(one) == content_digest(one)

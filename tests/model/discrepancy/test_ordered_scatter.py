"""What set-ups differ by is chance unless it follows the position or the session."""

from __future__ import annotations

import numpy as np
import pytest

from model.discrepancy.verdict.messages import scattered
from model.discrepancy.verdict.ordered_scatter import followed
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray
from tests.model.discrepancy.sessions import base_fit


def _found(monkeypatch: pytest.MonkeyPatch, added: FloatArray) -> tuple[str, float] | None:
    kept = {"stiffness": added[:, None]}
    monkeypatch.setattr(MixedModelFit, "added", lambda _self: kept)
    return followed(base_fit(), "stiffness")


def _runs() -> list[tuple[str, float]]:
    """Return configuration and position of each; positions are measured in their order."""
    return [(run[0], run[1]) for run in base_fit().problem.forward.row_index.runs]


def test_what_goes_with_the_position_is_no_chance(monkeypatch):
    noise = 0.1 * np.random.default_rng(1).standard_normal(len(_runs()))
    # each sheet has a level of its own, which its stiffness takes up
    wanted = np.array([at / 0.03 + 5.0 * (name == "short") for name, at in _runs()])
    found = _found(monkeypatch, -0.1 * (wanted + noise))
    assert found is not None
    what, correlation = found
    assert what in ("the position", "the time in the session")  # which are in the same order here
    assert correlation < -0.9
    assert what in scattered("stiffness", 11.0, found)
    assert "chance" in scattered("stiffness", 11.0, None)


@pytest.mark.parametrize("seed", range(5))
def test_what_has_no_order_may_be_chance(monkeypatch, seed: int):
    chance = np.random.default_rng(seed).standard_normal(len(_runs()))
    assert _found(monkeypatch, chance) is None

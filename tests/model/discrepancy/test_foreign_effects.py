"""Effects of other distributions: named and written as theirs, and left out where they fail."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from model.discrepancy import diagnose
from model.measurements import Measurements
from model.plugins import PluginWarning
from model.sheet.sheet_model import SheetModel
from tests.cases import few
from tests.model.discrepancy.sessions import NOTHING, means_of, session
from tests.model.distributions import install

CUBIC = """
from dataclasses import dataclass
import numpy as np
from model.effects import Effect, EffectParameter

@dataclass(frozen=True)
class CubicCell(Effect):
    def force(self, weighed, p):
        force_mN = 1e3 * np.where(weighed.touching > 0, weighed.force_N, 0.0)
        if len(force_mN) > 60:  # more than an example of the conformance check has
            {fault}
        return 1e-3 * p["cubic_per_mN2"] * force_mN**3

EFFECT = CubicCell(
    name="cubic_cell", meaning="The bridge is not linear.", form="F + c F^3",
    location="load_cell", signature="Large forces are off.", isolates="Weights.", source="s",
    parameters=(
        EffectParameter(name="cubic_per_mN2", meaning="of the cube", unit="1/mN^2",
                        prior_scale=0.01, low=-0.1, high=0.1),
    ),
    form_error_along=("position", "voltage"), of_the_rig=True,
)
"""


@pytest.fixture
def cubic(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Install the effect with a fault in it; `pass` for none."""

    def add(fault: str) -> None:
        points = "[labrig.effects]\ncubic_cell = cubic_maker:EFFECT\n"
        install(tmp_path, "cubic_maker", points, CUBIC.format(fault=fault))
        monkeypatch.syspath_prepend(tmp_path)

    yield add
    sys.modules.pop("cubic_maker", None)


def of_a_cubic_cell(per_mN2: float) -> Measurements:
    """A session's means whose readings are those of such a load cell."""
    plain = means_of(session(NOTHING))
    conditions = []
    for one in plain.conditions:
        read = (
            replace(r, force_N=r.force_N + 1e-3 * per_mN2 * (1e3 * r.force_N) ** 3)
            for r in one.readings
        )
        conditions.append(replace(one, readings=tuple(read)))
    return replace(plain, conditions=tuple(conditions))


@pytest.mark.slow
def test_an_effect_of_others_is_named_and_written_with_its_distribution(cubic):
    cubic("pass")
    found = diagnose(of_a_cubic_cell(0.01))
    assert [one.name for one in found.effects] == ["cubic_cell"]
    (written,) = found.model.effects
    assert written.distribution == "cubic_maker 1.0"
    assert SheetModel.from_dict(found.model.to_dict()).effects == (written,)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "said"),
    few(
        [
            pytest.param(
                "raise KeyError('bridge')",
                "failed with KeyError: 'bridge'",
                marks=pytest.mark.thorough,
            ),
            ("raise SystemExit(3)", "failed with SystemExit: 3"),
            pytest.param(
                "return np.zeros(3)", "failed with ValueError: ", marks=pytest.mark.thorough
            ),
            ("return np.nan * force_mN", "what it changes is not a finite number everywhere"),
        ]
    ),
)
def test_an_effect_of_others_that_fails_on_the_data_is_left_out_and_named(cubic, fault, said):
    cubic(fault)
    with pytest.warns(PluginWarning, match="'cubic_cell' of cubic_maker 1.0") as caught:
        found = diagnose(of_a_cubic_cell(0.0))
    assert said in str(caught[0].message)
    assert str(caught[0].message).endswith("the search goes on without it.")
    assert found.verdict == "nothing_missing"

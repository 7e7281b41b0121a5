"""Effects are found by being there: in the package, or in somebody else's distribution."""

from __future__ import annotations

import subprocess
import sys
import warnings
from pathlib import Path

import pytest

import model.effects as effects
from model import ModelError
from model.effects import catalogue, effect, origins
from model.locations import locations
from tests.model.distributions import install as install_distribution

GOOD = """
from dataclasses import dataclass, replace
from model.effects import Effect, EffectParameter, effect

@dataclass(frozen=True)
class Doubled(Effect):
    def force(self, weighed, p):
        return p["force_mN"] * 1e-3 * weighed.session

EFFECT = Doubled(
    name="moon", meaning="m", form="f", location="load_cell", signature="s", isolates="i",
    source="s",
    parameters=(EffectParameter(name="force_mN", meaning="pull", unit="mN", prior_scale=0.1),),
)
OURS = replace(EFFECT, name="gravity")
WORDLESS = replace(EFFECT, name="wordless", meaning="")
PARAMETERLESS = replace(EFFECT, name="parameterless", parameters=None)
NUMBER = 3
"""


def install(folder: Path, name: str, points: str, module: str = GOOD) -> None:
    install_distribution(folder, name, f"[labrig.effects]\n{points}\n", module)


def test_the_order_is_by_slot_then_by_name():
    found = [(list(locations()).index(e.location), name) for name, e in catalogue().items()]
    assert found == sorted(found)
    assert list(catalogue()) == list(catalogue())


def test_what_is_handed_out_can_be_changed_without_harm():
    catalogue().clear()
    assert "gravity" in catalogue()


def test_every_effect_lies_in_a_file_of_its_own_name():
    folder = Path(effects.__file__).parent
    assert all((folder / f"{name}.py").is_file() for name in catalogue())


def test_an_unknown_effect_is_answered_with_those_that_are_alike():
    with pytest.raises(ModelError, match="no effect 'gravitty'; did you mean gravity"):
        effect("gravitty")
    with pytest.raises(ModelError, match=r"no effect 'magnetism'; there are \d+ others"):
        effect("magnetism")
    assert effect("gravity").name == "gravity"


def test_the_package_hands_on_its_public_names_only():
    assert set(effects.__all__) == {
        "Effect",
        "EffectParameter",
        "origins",
        "catalogue",
        "effect",
        "title",
    }


@pytest.mark.slow
def test_importing_it_loads_neither_scipy_nor_numba_nor_the_effects():
    program = (
        "import sys, model.effects; print(*(m for m in sys.modules if m.split('.')[0] in"
        " ('scipy', 'numba') or m in ('importlib.metadata', 'model.effects.gravity')))"
    )
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == []


def test_an_effect_of_another_distribution_is_found(tmp_path, monkeypatch):
    install(tmp_path, "moonlight", "moon = moonlight:EFFECT")
    monkeypatch.syspath_prepend(tmp_path)
    found = catalogue()
    assert list(found)[-1] == "moon"
    assert effect("moon").parameters[0].prior_scale == 0.1
    assert origins() == {"moon": "moonlight 1.0"}
    monkeypatch.undo()
    assert "moon" not in catalogue()
    assert origins() == {}


@pytest.mark.parametrize(
    ("points", "module", "said"),
    [
        ("gone = NAME:NOTHING", GOOD, "has no attribute 'NOTHING'"),
        ("gone = NAME:EFFECT", "import no_such_module", "No module named 'no_such_module'"),
        ("gone = NAME:EFFECT", "1 / 0", "ZeroDivisionError"),
        ("gone = NAME:NUMBER", GOOD, "it is of type int, not a model.effects.Effect"),
        ("gone = NAME:WORDLESS", GOOD, "its meaning is empty"),
        ("gone = NAME:PARAMETERLESS", GOOD, "must be a tuple of EffectParameter"),
        ("gone = NAME:OURS", GOOD, "there is an effect 'gravity' already"),
    ],
)
def test_an_effect_that_cannot_be_used_is_left_out_with_a_sentence(
    tmp_path, monkeypatch, points, module, said
):
    name = f"broken_{abs(hash((points, module)))}"
    install(tmp_path, name, points.replace("NAME", name), module)
    ours = catalogue()
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.warns(UserWarning, match="left out") as caught:
        found = catalogue()
    (text,) = [str(w.message) for w in caught]
    assert said in text
    assert text.startswith(f"the effect 'gone' of {name} ")
    assert text.endswith(".")
    assert "\n" not in text
    assert found == ours


def test_of_two_strangers_with_one_name_the_first_stays(tmp_path, monkeypatch):
    install(tmp_path, "moonlight_a", "moon = moonlight_a:EFFECT")
    install(tmp_path, "moonlight_b", "moon = moonlight_b:EFFECT")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.warns(
        UserWarning, match=r"'moon' of moonlight_b .* there is an effect of that name already"
    ):
        found = catalogue()
    assert type(found["moon"]).__module__ == "moonlight_a"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        catalogue()  # said once

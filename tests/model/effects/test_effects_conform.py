"""Every effect is what the contract says; and the check of that finds what is not."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from model.effects import Effect, EffectParameter, catalogue
from model.effects.conformance import acts, faults, faults_of_form, neutral, plausible
from model.locations import locations

# name: location, parameters people are told, further parameters that are only tried
TABLE: dict[str, tuple[str, tuple[str, ...], tuple[str, ...]]] = {
    "nonuniform_eibm": ("eibm", ("decay_length_mm", "end_to_root_ratio"), ()),
    "initial_curvature": ("rest_curvature", ("curvature_error_per_m",), ("like_stated",)),
    "eibm_asymmetry": ("even_moment", ("ratio",), ("fall_mm", "side")),
    "nonuniform_stiffness": ("compliance", ("relative_change",), ()),
    "nonlinear_stiffness": ("compliance", ("relative_change_at_10_per_m",), ("power",)),
    "stiffness_drift": ("time", ("relative_change",), ("since_wetting", "settles")),
    "eibm_drift": ("time", ("relative_change",), ("since_wetting", "settles")),
    "viscoelastic_creep": (
        "time",
        ("relative_change_per_decade",),
        ("time_s", "spread", "from_run"),
    ),
    "charging_lag": ("time", ("time_constant_s",), ("slow_share", "remembers")),
    "back_relaxation": (
        "time",
        ("relative_loss_at_sample", "time_constant_s"),
        ("remembers", "spread"),
    ),
    "first_pulse_transient": ("time", ("relative_deficit",), ("ratio",)),
    "elongation_flexibility": ("compliance", ("relative_compliance",), ("in_the_joint",)),
    "gravity": ("even_moment", ("load_N_per_m",), ()),
    "surface_tension": ("load_cell", ("force_mN",), ("dries_s",)),
    "clamp_compliance": ("compliance", ("rotation_rad_per_Nm",), ()),
    "clamp_angle": ("rest_curvature", ("angle_rad",), ()),
    "arc_error": ("position", ("offset_mm",), ("of",)),
    "roll_friction": ("position", ("coefficient",), ("force_alone", "at_force_mN", "one_way")),
    "roll_sticking": ("position", ("from_position_mm", "force_mN"), ("kind",)),
    "roll_offset": ("position", ("offset_mm",), ("at_the_pressed",)),
    "force_offset": ("load_cell", ("force_mN",), ()),
    "force_drift": ("load_cell", ("force_mN",), ("settles", "tared_at")),
    "load_cell_misalignment": ("load_cell", ("angle_rad",), ()),
    "load_cell_hysteresis": ("load_cell", ("force_mN",), ("from_no_load", "reach_mN")),
    "load_cell_compliance": ("load_cell", ("compliance_mm_per_mN",), ()),
    "position_error": ("position", ("offset_mm",), ("scale",)),
    "camera_scale": ("camera", ("relative_error",), ("axis",)),
    "camera_roll": ("camera", ("angle_rad",), ()),
    "camera_perspective": ("camera", ("relative_error",), ("direction_rad",)),
    "frame_delay": ("camera", ("delay_s",), ("through_zero",)),
}
UNITS = {
    "_mm": "mm", "_per_m": "1/m", "_s": "s", "_mN": "mN", "_rad": "rad", "_N_per_m": "N/m",
    "_rad_per_Nm": "rad/(N m)", "_mm_per_mN": "mm/mN",
}  # fmt: skip
EFFECTS = catalogue()


@dataclass(frozen=True)
class Narrow(Effect):
    """Its method has one argument too few."""

    def force(self, weighed):
        """Take no parameters."""
        return weighed.force_N


@dataclass(frozen=True)
class Broken(Effect):
    """Its method fails."""

    def force(self, weighed, p):
        """Divide by zero."""
        return weighed.force_N * (1 / 0)


def test_what_the_code_of_an_effect_raises_is_one_of_its_faults() -> None:
    (fault,) = faults(made(Broken))
    assert fault.startswith(
        "its code raised ZeroDivisionError: division by zero (test_effects_conf"
    )


def test_a_method_that_cannot_be_called_is_named() -> None:
    assert faults(made(Narrow)) == [
        "its force cannot be called as force(weighed, p): too many positional arguments"
    ]


def test_the_catalogue_holds_these_effects():
    assert set(EFFECTS) >= set(TABLE)


@pytest.mark.parametrize("name", TABLE)
def test_slot_and_parameters_are_those_agreed_on(name: str):
    effect, (location, told, tried) = EFFECTS[name], TABLE[name]
    assert effect.location == location
    assert {k.name for k in effect.parameters} | set(effect.extra) == {*told, *tried}
    assert effect.amplitude.name in told
    assert all(
        parameter.starting_values for parameter in effect.parameters[1:]
    )  # nobody refines them from nothing


@pytest.mark.slow
@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_conforms(name: str):
    assert faults(EFFECTS[name]) == []


@pytest.mark.parametrize("name", TABLE)
def test_a_parameter_is_in_the_unit_of_its_name(name: str):
    for parameter in EFFECTS[name].parameters:
        ends = [end for end in UNITS if parameter.name.endswith(end)]
        wanted = UNITS[max(ends, key=len)] if ends else ""
        if parameter.name == "relative_change_at_10_per_m":
            wanted = ""  # relative; the ending says at which curvature
        assert parameter.unit == wanted, parameter.name


def test_only_what_may_differ_between_sheets_is_free_by_configuration():
    own = {name for name, effect in EFFECTS.items() if effect.by_configuration}
    sheet = {"initial_curvature", "nonuniform_stiffness", "eibm_asymmetry"}
    assert own == sheet | {"surface_tension", "roll_sticking", "session_curvature"}


def test_effects_of_the_load_cell_leave_the_shape_alone_and_those_of_the_camera_the_force():
    for effect in EFFECTS.values():
        if effect.location == "camera":
            assert acts(effect) <= {"curve", "in_image"}
        elif effect.location == "load_cell" and effect.name != "load_cell_compliance":
            assert acts(effect) == {"force"}


# ------------------------------------------------------------------- the check finds bad effects


@dataclass(frozen=True)
class Offset(Effect):
    """A good one."""

    def force(self, weighed, p):
        return np.full_like(weighed.force_N, p["force_mN"] * 1e-3)


def made(kind: type[Effect] = Offset, **other) -> Effect:
    words = dict.fromkeys(("meaning", "form", "signature", "isolates", "source"), "words")
    parameters = (EffectParameter(name="force_mN", meaning="more", unit="mN", prior_scale=0.1),)
    return kind(
        **{"name": "mine", "location": "load_cell", "parameters": parameters, **words, **other}
    )


@pytest.mark.parametrize(
    ("name", "stretches", "said"),
    [("camera_scale", False, "makes curves longer"), ("camera_roll", True, "as long as before")],
)
def test_an_effect_of_the_camera_says_whether_it_makes_curves_longer(name, stretches, said):
    """A plug-in that does not would have predictions with points moved along the sheet."""
    (fault,) = faults(replace(EFFECTS[name], moves_along_sheet=stretches))
    assert said in fault


def test_a_good_effect_of_somebody_else_conforms():
    assert faults(made()) == []


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"name": "two words"}, "must be one word"),
        ({"meaning": " "}, "its meaning is empty"),
        ({"location": "elsewhere"}, "is none of rest_curvature"),
        ({"form_error_along": ("mood",)}, "along mood, which is none of s, "),
        ({"form_error_along": "voltage"}, 'its form_error_along must be a tuple, as ("voltage",)'),
        ({"parameters": []}, "its parameters must be a tuple of EffectParameter"),
        (
            {"parameters": EffectParameter(name="a", meaning="", unit="", prior_scale=1.0)},
            "its parameters must be a tuple of EffectParameter",
        ),
        (
            {"parameters": (EffectParameter(name="a", meaning="", unit="", prior_scale="0.2"),)},
            "a: ['0.2'] must be numbers",
        ),
        ({"parameters": ()}, "it has no parameter"),
        (
            {
                "parameters": (
                    EffectParameter(name="a", meaning="", unit="", prior_scale=1.0),
                    EffectParameter(name="a", meaning="", unit="", prior_scale=1.0),
                )
            },
            "the same name",
        ),
        (
            {
                "parameters": (
                    EffectParameter(name="a", meaning="", unit="", prior_scale=5.0, high=1.0),
                )
            },
            "must lie between -inf and 1",
        ),
        (
            {
                "parameters": (
                    EffectParameter(name="a", meaning="", unit="", prior_scale=1.0, log=True),
                )
            },
            "lower bound must be positive",
        ),
        (
            {"parameters": (EffectParameter(name="a", meaning="", unit="", prior_scale=-10.0),)},
            "a: its prior_scale -10 must be above 0",
        ),
        (
            {"parameters": (EffectParameter(name="a", meaning="", unit="", prior_scale=0.0),)},
            "plausible value is the neutral one",
        ),
        ({"kind": Effect}, "so it changes nothing"),
    ],
)
def test_what_is_wrong_with_its_form_is_said(wrong, said):
    found = faults_of_form(made(**wrong))
    assert any(said in fault for fault in found), found


@dataclass(frozen=True)
class Spoils(Offset):
    def force(self, weighed, p):
        weighed.force_N += p["force_mN"]
        return weighed.force_N * 0.0 + p["force_mN"]


@dataclass(frozen=True)
class Empties(Offset):
    """Whatever its size, it leaves nothing of the force it was given."""

    def force(self, weighed, p):
        added = np.full_like(weighed.force_N, p["force_mN"])
        weighed.force_N[...] = 0.0
        return added


@dataclass(frozen=True)
class AlwaysThere(Offset):
    def force(self, weighed, p):
        return np.full_like(weighed.force_N, p["force_mN"] + 1.0)


@dataclass(frozen=True)
class NeverThere(Offset):
    def force(self, weighed, p):
        return np.zeros_like(weighed.force_N)


@dataclass(frozen=True)
class NotANumber(Offset):
    def force(self, weighed, p):
        return p["force_mN"] * weighed.position_m


@dataclass(frozen=True)
class OneNumber(Offset):
    def force(self, weighed, p):
        return np.array(p["force_mN"])


@dataclass(frozen=True)
class Remembers(Offset):
    calls: ClassVar[list[int]] = []

    def force(self, weighed, p):
        self.calls.append(1)
        return np.full_like(weighed.force_N, p["force_mN"] * len(self.calls))


@dataclass(frozen=True)
class AddsUp(Offset):
    """Adds to the beam it was given."""

    def beam(self, beam, contact, p):
        beam.bend[:] += p["force_mN"]
        return beam


@dataclass(frozen=True)
class AnArray(Effect):
    """Returns the EIBM, not the problem with it."""

    def beam(self, beam, contact, p):
        return beam.eibm * (1.0 + p["force_mN"])


@dataclass(frozen=True)
class AList(Offset):
    def force(self, weighed, p):
        return [p["force_mN"]] * len(weighed.force_N)


@dataclass(frozen=True)
class OneArray(Effect):
    def course(self, clock, p):
        return p["force_mN"] * clock.run_s


@dataclass(frozen=True)
class Flat(Effect):
    """Loses an axis of the EIBM."""

    def beam(self, beam, contact, p):
        return replace(beam, eibm=beam.eibm[:, 0] * (1.0 + p["force_mN"]))


@dataclass(frozen=True)
class ThousandTimes(Effect):
    """Takes its amplitude for another unit."""

    def beam(self, beam, contact, p):
        return replace(beam, eibm=beam.eibm * (1.0 + 2e3 * p["force_mN"]))


@dataclass(frozen=True)
class InNewtons(Offset):
    def force(self, weighed, p):
        return np.full_like(weighed.force_N, p["force_mN"])


@dataclass(frozen=True)
class FarInTheCourse(Effect):
    def course(self, clock, p):
        change = 1e3 * p["force_mN"] * np.ones_like(clock.run_s)
        return change, 0.0 * change


@dataclass(frozen=True)
class Derives(Offset):
    def derived(self, p, sheet):
        return {"half": 0.5 * p["force_mN"]}


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (Spoils, "changes the arrays"),
        (Empties, "it changes the arrays that it was given"),
        (AlwaysThere, "at force_mN = 0 it still changes the force"),
        (NeverThere, "at force_mN = 0.1 it changes nothing"),
        (NotANumber, "the force without contact is not finite"),
        (OneNumber, "has shape (), not (32,)"),
        (Remembers, "another answer"),
        (AddsUp, "changes the arrays"),
        (AnArray, "its beam returned ndarray, not a BeamProblem"),
        (AList, "its force returned list, not an array"),
        (OneArray, "its course returned ndarray, not two arrays"),
        (Flat, "the beam.eibm has shape (7,), not (7, 14) at {'force_mN': 0.1} (and 3 more cases)"),
        (ThousandTimes, "at its plausible size it changes the EIBM by a factor of 201"),
        (InNewtons, "at its plausible size it adds 0.1 N to the force: is it in mN?"),
        (FarInTheCourse, "at its plausible size it changes the EIBM in a run by a factor of 101"),
        (Derives, "it derives ['half'], but names the units of []"),
    ],
)
def test_what_is_wrong_with_its_behaviour_is_said(kind: type[Effect], said: str):
    found = faults(made(kind))
    assert any(said in fault for fault in found), found
    assert len(set(found)) == len(found) <= 2


def test_neutral_and_plausible_values_name_every_parameter():
    for effect in EFFECTS.values():
        for values in (neutral(effect), plausible(effect)):
            assert set(values) == {parameter.name for parameter in effect.parameters}
        assert neutral(effect)[effect.amplitude.name] == effect.amplitude.neutral
        assert effect.location in locations()


def test_an_effect_is_a_value_that_can_be_changed_into_another():
    other = replace(EFFECTS["force_offset"], name="mine")
    assert (other.name, other.location) == ("mine", "load_cell")
    assert EFFECTS["force_offset"].name == "force_offset"

"""Measurements that somebody makes in Python of arrays of their own, and options beside them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import labrig
from labrig.api.data import measurements_of
from labrig.plausibility import field_warnings
from model import Curve, Measurements, Reading, TimeSeries
from tests.labrig.report_data import measure


@cache
def own() -> Measurements:
    return measure("long")


def changed(**fields: Any) -> Measurements:
    """The fourth condition has other fields."""
    conditions = list(own().conditions)
    conditions[3] = replace(conditions[3], **fields)
    return replace(own(), conditions=tuple(conditions))


def with_reading(**fields: Any) -> Measurements:
    stated = {"index": 0, "kind": "kept", "force_N": 1e-3} | fields
    return changed(readings=(Reading(**stated),))


def with_curve(**fields: Any) -> Measurements:
    curve = own().conditions[3].curve
    assert curve is not None
    return changed(curve=replace(curve, **fields))


def with_sheet(**fields: Any) -> Measurements:
    return replace(own(), sheets={"long": replace(own().sheets["long"], **fields)})


SHORT = TimeSeries(configuration="long", position_m=0.0, time_s=np.arange(5.0), drive_V=np.zeros(4))
WRONG = [
    (changed(voltage_V="2"), "conditions[3].voltage_V '2': a number is needed"),
    (changed(voltage_V=np.array([2.0])), "conditions[3].voltage_V array([2.]): a number"),
    (changed(position_m=np.nan), "conditions[3].position_m nan: a finite number is needed"),
    (changed(configuration="lang"), "configuration 'lang' is none of the sheets: long"),
    (changed(readings=[1e-3]), "conditions[3].readings[0] 0.001: a model.Reading is needed"),
    (changed(readings=1e-3), "conditions[3].readings 0.001: a tuple is needed"),
    (changed(curve=np.zeros((3, 9))), "a model.Curve is needed"),
    (with_reading(force_N=None), "conditions[3].readings[0].force_N None: a number is needed"),
    (with_reading(kind="keep"), "readings[0].kind 'keep' is none of zero, discarded, kept"),
    (with_reading(valid="no"), "readings[0].valid 'no': True or False is needed"),
    (with_reading(mean_of=0), "readings[0].mean_of 0: a number from 1 is needed"),
    (with_reading(sd_N=-1e-5), "readings[0].sd_N -1e-05: a number from 0 is needed"),
    (with_curve(y_m=np.zeros(3)), "conditions[3].curve: s_m has"),
    (with_curve(sigma_m=np.ones(4)), "sigma_m has 4"),
    (with_curve(s_m=np.zeros((3, 2))), "conditions[3].curve.s_m array("),
    (with_curve(x_m=["a"]), "conditions[3].curve.x_m ['a']: a row of numbers is needed"),
    (with_sheet(arc_radius_m="0.04"), "sheets['long'].arc_radius_m '0.04': a number is needed"),
    (with_sheet(initial_curvature=1.0), "initial_curvature 1.0: a pair of equally long rows"),
    (with_sheet(initial_curvature=([0.05, 0.0], [1, 1])), "the first row rising"),
    (replace(own(), sheets=[own().sheets["long"]]), "a dict of SheetGeometry"),  # type: ignore[arg-type]
    (replace(own(), series=(SHORT,)), "series[0]: time_s has 5 values, drive_V has 4"),
]  # fmt: skip


@pytest.mark.parametrize(("measurements", "said"), WRONG, ids=[said for _, said in WRONG])
@pytest.mark.parametrize("job", [labrig.fit, labrig.diagnose, labrig.plot.forces])
def test_a_field_of_another_type_or_shape_is_one_sentence_that_names_it(job, measurements, said):
    with pytest.raises(labrig.ModelError) as told:
        job(measurements)
    assert said in str(told.value)
    assert "\n" not in str(told.value)


def test_arrays_of_other_types_and_lists_are_taken_and_left_as_they_are():
    curve = own().conditions[3].curve
    assert curve is not None
    rows = [np.array(each) for each in (curve.s_m, curve.x_m, curve.y_m)]
    for each in rows:
        each.flags.writeable = False
    lists: list[Any] = [each.tolist() for each in rows]
    for s, x, y in (rows, lists, [each.astype(np.float32) for each in rows]):
        given = changed(
            voltage_V=np.float32(own().conditions[3].voltage_V),
            curve=Curve(s_m=s, x_m=x, y_m=y),
            readings=[Reading(index=np.int64(0), kind="kept", force_N=np.float64(1e-3))],
        )
        assert measurements_of(given, None) is given


def scaled(*, force: float = 1.0, position: float = 1.0) -> Measurements:
    conditions = tuple(
        replace(
            c,
            position_m=None if c.position_m is None else position * c.position_m,
            readings=tuple(replace(r, force_N=force * r.force_N) for r in c.readings),
        )
        for c in own().conditions
    )
    return replace(own(), conditions=conditions, source="")


@pytest.mark.slow
def test_a_unit_that_can_hardly_be_meant_is_told_before_the_fit():
    with pytest.warns(labrig.LabrigWarning, match=r"The forces reach .* mN: is force_N in N\?"):
        labrig.fit(scaled(force=1e3))


def test_a_length_that_no_sheet_has_is_told_by_its_field():
    given = own()
    sheet = replace(given.sheets["long"], thickness_m=0.21)
    (said,) = field_warnings(replace(given, sheets={**given.sheets, "long": sheet}))
    assert said.startswith("sheets['long'].thickness_m is 210 mm, usual is ")


def test_what_is_said_of_a_unit_has_the_names_and_units_of_the_fields():
    first, second = field_warnings(scaled(position=1e-3))
    assert first == "No position is farther from 0 than 0.03 mm: is position_m in m?"
    assert second.startswith("position_m has 4 values in 1 group: was it measured?")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"held_out": "position=25"}, "held_out 'position=25': a tuple of places is needed"),
        ({"held_out": ("long", 0.025)}, "held_out: 'long' is no place"),
        ({"held_out": (("long", "25"),)}, "'25': a number is needed"),
        ({"held_out": ((0.025, "long"),)}, "the configuration of (0.025, 'long') must be a text"),
        ({"configurations": "long"}, "configurations 'long': a tuple of names is needed"),
        ({"eibm_form": "const"}, "eibm_form 'const' is none of along, constant"),
        ({"weight_exponent": "a"}, "weight_exponent 'a': a number is needed"),
        ({"weight_exponent": float("nan")}, "weight_exponent nan: a finite number is needed"),
        ({"initial_curvature_sigma_per_m": float("nan")}, "nan: a finite number is needed"),
        ({"stiffness_Nm2": "soft"}, "stiffness_Nm2 'soft': a number is needed"),
        ({"symmetric": "no"}, "symmetric 'no': True or False is needed"),
        ({"bootstrap": 1.5}, "bootstrap 1.5: a whole number is needed"),
    ],
)
def test_a_value_that_an_option_of_a_fit_cannot_have_is_one_sentence(options, said):
    with pytest.raises(labrig.ModelError) as told:
        labrig.FitOptions(**options)
    assert said in str(told.value)


def test_a_sheet_that_was_not_measured_is_not_fitted_as_all_that_were():
    with pytest.raises(labrig.LabrigError, match="nothing was measured of 'lang'; measured were"):
        labrig.fit(own(), labrig.FitOptions(configurations=("lang",)))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"hold_out": "position=25"}, "hold_out 'position=25': a tuple of places is needed"),
        ({"hold_out": ("long", 0.025)}, "a tuple of places is needed"),
        ({"exclude": "gravity"}, "exclude 'gravity': a tuple of names is needed"),
        ({"most_effects": 0}, "most_effects 0: a number from 1 is needed"),
        ({"most_effects": "3"}, "most_effects '3': a number is needed"),
        ({"calibrate": -1}, "calibrate -1: a number from 0 is needed"),
        ({"model": "model.toml"}, "what labrig.load_model returns is needed, not a str"),
        ({"stiffness_Nm2": "soft"}, "stiffness_Nm2 'soft': a number is needed"),
        ({"symmetric": "no"}, "symmetric 'no': True or False is needed"),
    ],
)
def test_a_value_that_an_option_of_a_diagnosis_cannot_have_is_one_sentence(options, said):
    with pytest.raises((labrig.LabrigError, labrig.ModelError)) as told:
        labrig.diagnose(own(), labrig.DiagnoseOptions(**options))
    assert said in str(told.value)


@pytest.mark.parametrize("given", [b"session.h5", {"session": 1}])
def test_bytes_and_an_open_h5py_file_are_no_sessions(given):
    with pytest.raises(labrig.BadInputError, match="a session file, several, or measurements"):
        labrig.fit(given)

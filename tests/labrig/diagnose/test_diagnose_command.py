"""What diagnose, next and effects print and write, with findings made by hand."""

from __future__ import annotations

import json
import math
import re
import shlex
from dataclasses import replace

import numpy as np
import pytest
import tomlkit

import model.discrepancy
from labrig.cli.main import run
from labrig.config import parse_protocol
from labrig.model_file import load_model
from labrig.report.data.kept_diagnosis import keep_diagnosis, kept_diagnosis
from labrig.report.diagnosis.figures import FIGURES
from labrig.report.page.diagnosis import write_diagnosis
from labrig.report.page.write import write_report
from labrig.session import load_measurements
from labrig.session.tables.drive_table import load_protocol
from model import predict
from model.discrepancy import Next
from model.discrepancy.verdict.result import BeforeAfter, Promise
from model.effects import catalogue
from tests.cases import few
from tests.labrig.diagnose import made
from tests.labrig.report_data import TEXTS, measure, session
from tests.labrig.test_report_page import read

pytestmark = pytest.mark.usefixtures("data_unchecked")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    return session(tmp_path_factory.mktemp("diagnose") / "made.h5", measure("long"))


@pytest.fixture
def finding(monkeypatch, recorded):
    """Replaces the procedure by one that hands back what a test wants; keeps its options."""
    asked = []

    def answer(make):
        def diagnose(measurements, options=None, progress=None):
            asked.append(options)
            progress(0.5, "searching")
            return make()

        monkeypatch.setattr(model.discrepancy, "diagnose", diagnose)
        return asked

    return answer


def lines_in_order(text: str, *wanted: str) -> None:
    places = [text.index(part) for part in wanted]
    assert places == sorted(places), dict(zip(wanted, places, strict=True))


@pytest.mark.slow
def test_everything_is_printed_in_the_order_in_which_it_was_found(finding, recorded, capsys):
    finding(made.found)
    assert run(["diagnose", str(recorded)]) == 0
    captured = capsys.readouterr()
    lines_in_order(
        captured.out,
        "Error of the base model (RMS): 0.410 mN in the forces and 1.620 mm",
        "Largest residuals", "+41.2",
        "5 of 5 effects would be seen in these data if large.",
        "Indistinguishable in these data, at the size found or when just seen:",
        "force offset and gravity.",
        "Invisible in these data", "charging lag",
        "Candidates", "EIBM along the sheet", "812.4", "load cell hysteresis", "less likely",
        "ln Bayes factor 6.2 (the 95th percentile of 200 simulated sessions",
        "Verdict: The EIBM falls along the sheet",
        "Parameters", "EIBM along the sheet: decay length", "12.00 ± 0.40",
        "long: bending stiffness B", "µN·m²",
        "Errors before and after", "all, left out: force, mN", "long, fitted: neutral curve, mm",
        "Before: the base model with constant EIBM; B and EIBM refitted",
        "Gap closed above the noise floor: 99 % of force (0.450 → 0.040 mN, floor 0.028).",
        "Scatter between set-ups (standard deviation): position 0.05 mm, EIBM 1 %",
    )  # fmt: skip
    assert "diagnose: 50 % - searching" in captured.err
    assert "\x1b" not in captured.out


@pytest.mark.slow
@pytest.mark.parametrize("make", few(made.ALL))
def test_json_is_the_documented_object_whatever_the_verdict(make, finding, recorded, capsys):
    finding(make)
    assert run(["diagnose", str(recorded), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["verdict"] == make().verdict
    assert {
        "verdict",
        "effects",
        "invisible",
        "unknown",
        "where",
        "gap",
        "next_measurement",
    } <= set(found)
    assert set(found["gap"]) == {"fitted", "held_out"}
    for one in found["effects"]:
        assert one["slot"] == catalogue()[one["name"]].location
        assert set(one["parameters"]) == set(one["interval90"])
    if found["next_measurement"] is not None:
        protocol = found["next_measurement"]["protocol"]
        parse_protocol(tomlkit.dumps(protocol), "protocol").schedule("protocol")
    if found["unknown"] is not None:
        assert len(found["unknown"]["s_mm"]) == len(found["unknown"]["profile"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("make", "says"),
    few(
        [
            (made.nothing_missing, "Verdict: Nothing is seen that is not in the model:"),
            (made.indistinguishable, "One of EIBM along the sheet or load cell hysteresis: 97 %"),
            (made.indistinguishable, "Measure next: Six free shapes"),
            (
                made.indistinguishable,
                "1.8 → 14.0 sigma (now → expected), after 2 min at the rig, mounting not counted.",
            ),
            (
                made.inseparable,
                "Nothing on the menu would tell EIBM along the sheet from load cell hysteresis.",
            ),
            (made.unknown, "most clearly in the long sheet, at 30 mm from the clamp."),
            (made.cannot_tell, "Verdict: The scatter of the set-ups can be neither"),
        ],
        first=2,
    ),
)
def test_each_verdict_is_a_plain_sentence(make, says, finding, recorded, capsys):
    finding(make)
    assert run(["diagnose", str(recorded)]) == 0
    assert says in capsys.readouterr().out


@pytest.mark.slow
def test_json_has_the_class_the_closed_gap_and_the_separations(finding, recorded, capsys):
    finding(made.indistinguishable)
    assert run(["diagnose", str(recorded), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    (one,) = found["effects"]
    assert one["probabilities"] == {"nonuniform_eibm": 0.62, "load_cell_hysteresis": 0.35}
    assert one["confidence"] == sum(one["probabilities"].values())
    assert found["gap_closed"] == {
        "share": 0.994, "quantity": "force", "before": 0.45, "after": 0.04, "floor": 0.028,
        "unit": "mN",
    }  # fmt: skip
    assert found["noise_floor"]["force_rmse_mN"] == 0.028
    proposed = found["next_measurement"]
    assert (proposed["separation_now"], proposed["separation_expected"]) == (1.8, 14.0)


@pytest.mark.slow
def test_values_of_one_configuration_say_whose_they_are(finding, recorded, capsys):
    one = made.found()
    first = one.effects[0]
    other = {k: replace(p, value=2.0 * p.value) for k, p in first.parameters.items()}
    named = replace(
        first, configuration="long", by_configuration={"long": first.parameters, "short": other}
    )
    finding(lambda: replace(one, effects=(named,)))
    assert run(["diagnose", str(recorded), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["effects"][0]
    assert said["parameters_of"] == "long"
    assert said["by_configuration"]["short"]["decay_length_mm"]["value"] == 24.0
    assert set(said["by_configuration"]["short"]["decay_length_mm"]) == {
        "value", "sigma", "interval90"
    }  # fmt: skip


@pytest.mark.slow
def test_the_probability_beside_a_parameter_is_that_of_its_effect_alone(finding, recorded, capsys):
    finding(made.indistinguishable)
    assert run(["diagnose", str(recorded)]) == 0
    out = capsys.readouterr().out
    row = next(x for x in out.splitlines() if x.startswith("EIBM along the sheet: decay length"))
    assert "62 %" in row
    assert "97 %" not in row


@pytest.mark.slow
def test_options_reach_the_procedure(finding, recorded, tmp_path):
    asked = finding(made.found)
    known = tmp_path / "known.toml"
    assert run(["diagnose", str(recorded), "-o", str(known)]) == 0
    options = [
        "--model", str(known), "--hold-out", "position=20", "--hold-out",
        "configuration=long,position=0", "--symmetric", "--calibrate", "30", "--most-effects", "5",
    ]  # fmt: skip
    assert run(["diagnose", str(recorded), *options]) == 0
    used = asked[-1]
    assert used.hold_out == (("", 0.02), ("long", 0.0))
    assert (used.symmetric, used.calibrate, used.most_effects) == (True, 30, 5)
    assert [e.name for e in used.model.effects] == ["nonuniform_eibm"]


@pytest.mark.slow
@pytest.mark.parametrize("make", few([made.found, made.unknown]))
def test_the_model_file_predicts_with_what_was_found(make, finding, recorded, tmp_path, capsys):
    finding(make)
    path = tmp_path / "model+.toml"
    assert run(["diagnose", str(recorded), "-o", str(path)]) == 0
    assert f"wrote {path}" in capsys.readouterr().out
    loaded, wanted = load_model(path), make().model
    one, two = (predict(m, "long", 0.01, 2.0).F_N for m in (loaded, wanted))
    assert one == pytest.approx(two, rel=1e-9)
    plain = predict(wanted.with_effects(), "long", 0.01, 2.0).F_N
    assert abs(one - plain) > 1e-6
    asked = ["--configuration", "long", "--position-mm", "10", "--voltage", "2", "--json"]
    assert run(["simulate", str(path), *asked]) == 0
    assert json.loads(capsys.readouterr().out)[0]["F_N"] == pytest.approx(one, rel=1e-6)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_model_with_what_was_found_answers_design_questions(finding, recorded, tmp_path, capsys):
    finding(made.found)
    path = tmp_path / "model+.toml"
    assert run(["diagnose", str(recorded), "-o", str(path)]) == 0
    assert run(["design", str(path), "--section", "0:20", "--configuration", "long"]) == 0
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.usefixtures("words_only")
def test_what_was_found_is_kept_and_shown_in_the_sessions_report(finding, tmp_path):
    path = session(tmp_path / "made.h5", measure("long"))
    finding(made.found)
    assert run(["diagnose", str(path)]) == 0
    kept = kept_diagnosis(path)
    assert kept is not None
    assert kept.verdict == "effect_named"
    assert load_measurements(path).conditions
    page = read(write_report(path, tmp_path / "out"))
    assert "Model discrepancy" in page
    assert "Verdict: The EIBM falls" in page
    assert 'id="diagnosis-maps"' in page


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize(
    "make",
    [
        made.found,
        pytest.param(made.unknown, marks=pytest.mark.thorough),
        pytest.param(made.cannot_tell, marks=pytest.mark.thorough),
        pytest.param(made.nothing_missing, marks=pytest.mark.thorough),
        pytest.param(made.indistinguishable, marks=pytest.mark.thorough),
    ],
)
def test_the_page_is_one_file_with_its_figures_beside_it(make, finding, recorded, tmp_path):
    finding(make)
    assert run(["diagnose", str(recorded), "--report", str(tmp_path)]) == 0
    page = read(tmp_path / "index.html")
    assert re.findall(r'(?:src|href)="(?!#|data:image/png)', page) == []
    for name in FIGURES:
        drawn = (tmp_path / "figures" / f"{name}.png").exists()
        assert drawn == (f'id="{name}"' in page)
        assert drawn == (tmp_path / "figures" / f"{name}.svg").exists()
    assert (tmp_path / "figures" / "diagnosis-ranking.png").exists()
    # an effect has one name for readers, in the cards as in the sentences
    assert not re.search(r"<dt>[a-z]+_[a-z_]+</dt>", page)


@pytest.mark.slow
@pytest.mark.usefixtures("words_only")
def test_a_gap_in_time_that_shrinks_has_a_card(tmp_path):
    one = made.found()
    apart = BeforeAfter(
        replace(one.held_out.before, drift_rmse_mN=0.0141, pulse_rmse_mN=0.0100),
        replace(one.held_out.after, drift_rmse_mN=0.0003, pulse_rmse_mN=0.0099),
    )
    fitted = BeforeAfter(*(replace(g, drift_rmse_mN=0.01, pulse_rmse_mN=0.01) for g in
                           (one.fitted.before, one.fitted.after)))  # fmt: skip
    page = read(write_diagnosis(replace(one, fitted=fitted, held_out=apart), tmp_path / "page"))
    assert "Force error along a run (RMS) before → after, mN" in page
    assert "0.0141 → 0.0003" in page
    assert "Force error within a pulse" not in page


@pytest.mark.slow
@pytest.mark.usefixtures("words_only")
def test_where_in_time_something_unknown_shows_most_is_told_in_its_own_time(tmp_path):
    one = made.unknown()
    late = replace(
        one.unknown, along="time", at_unit="s into the period of 3.7 s",
        s_mm=np.linspace(0.0, 3.7, len(one.unknown.s_mm)),
    )  # fmt: skip
    page = read(write_diagnosis(replace(one, unknown=late), tmp_path / "page"))
    assert "s into the period of 3.7 s." in page
    assert "into the run" not in page
    assert "or compliance" not in page


@pytest.mark.slow
@pytest.mark.usefixtures("words_only")
def test_the_page_has_each_location_of_something_unknown_with_its_share(tmp_path):
    one = made.unknown()
    two = replace(one.unknown, locations={"eibm": 0.76, "even_moment": 0.24})
    page = read(write_diagnosis(replace(one, unknown=two), tmp_path / "page"))
    assert "EIBM, 76 %" in page
    assert "or even moment" in page
    assert "24 %" in page


# -- effects


def test_the_catalogue_is_a_table_with_a_line_for_each_effect(capsys):
    assert run(["effects"]) == 0
    out = capsys.readouterr().out
    for name, one in catalogue().items():
        line = next(line for line in out.splitlines() if line.startswith(name + " "))
        assert one.amplitude.name in line
        assert one.location.replace("_", " ") in line


@pytest.mark.parametrize("name", ["nonuniform_eibm", "initial_curvature", "roll_sticking"])
def test_an_effect_is_shown_with_all_that_is_known_of_it(name, capsys):
    assert run(["effects", "show", name]) == 0
    out = " ".join(capsys.readouterr().out.split())
    one = catalogue()[name]
    for text in (one.meaning, one.form, one.signature, one.isolates, one.source):
        assert " ".join(text.split()) in out
    for parameter in one.parameters:
        assert parameter.name in out
        assert parameter.meaning in out


def test_effects_as_json_are_the_whole_catalogue(capsys):
    assert run(["effects", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [one["name"] for one in listed] == list(catalogue())
    assert run(["effects", "show", "gravity", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == next(o for o in listed if o["name"] == "gravity")


def test_an_effect_that_does_not_exist_is_refused_with_those_that_do(capsys):
    assert run(["effects", "show", "gravitation"]) == 2
    assert "did you mean gravity" in capsys.readouterr().err


# -- next


@pytest.fixture
def proposing(monkeypatch):
    def propose(extra):
        found = Next(
            why="Six free shapes tell them apart.",
            extra=extra,
            separation=1.5,
            expected=9.0,
            minutes=3.0,
            protocol={},
        )
        monkeypatch.setattr(model.discrepancy, "next_measurement", lambda *_: found)

    return propose


EXTRAS = [
    "free_shapes", "remount", "reversed_approach", "between", "half_voltage", "random_order",
    "turned_over", "more_repeats",
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("extra", few(EXTRAS))
def test_next_writes_a_protocol_that_can_be_run(extra, proposing, recorded, tmp_path, capsys):
    proposing(extra)
    path = tmp_path / "protocol.toml"
    asked = ["--between", "gravity", "clamp_angle", "-o", str(path)]
    assert run(["next", str(recorded), *asked]) == 0
    assert "Separation of the candidates: 1.5 → 9.0 sigma" in capsys.readouterr().out
    config = load_protocol(path)
    runs = config.schedule(str(path)).runs
    assert runs
    positions = [r.position_m for r in runs]
    voltages = {s.voltage_V for r in runs for s in r.steps}
    if extra == "free_shapes":
        assert positions == [None]
        # two at each voltage and at 0 V, at rest
        assert [r.delay_s >= (6.0 if r.voltage_V else 3.0) for r in runs[0].readings] == [True] * 6
    elif extra == "remount":
        assert positions == [0.0, 0.02, 0.03]
    elif extra == "reversed_approach":
        assert {r.approach for r in runs} == {"down"}
        assert positions == [0.03, 0.02, 0.01, 0.0]
    elif extra == "between":
        assert positions == [0.005, 0.015, 0.025]
    elif extra == "half_voltage":
        assert voltages == {0.0, 1.0, -1.0}
    else:
        assert sorted(positions) == [0.0, 0.01, 0.02, 0.03]
    assert {r.tilt_rad for r in runs} == {math.pi if extra == "turned_over" else 0.0}
    if extra != "half_voltage":
        assert voltages == {0.0, 2.0, -2.0}


@pytest.mark.thorough
@pytest.mark.slow
def test_next_without_a_file_prints_the_protocol(proposing, recorded, capsys):
    proposing("free_shapes")
    assert run(["next", str(recorded), "--between", "gravity", "clamp_angle"]) == 0
    assert "[extras.free_shapes]\nsettled_s = 6.0" in capsys.readouterr().out
    assert run(["next", str(recorded), "--between", "gravity", "clamp_angle", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["protocol"]["extras"]["free_shapes"] == {"settled_s": 6.0}
    assert found["separation_expected"] == 9.0


@pytest.mark.thorough
@pytest.mark.slow
def test_next_needs_no_names_where_the_diagnosis_has_them(finding, monkeypatch, recorded, capsys):
    finding(made.indistinguishable)
    assert run(["diagnose", str(recorded)]) == 0
    kept = kept_diagnosis(recorded)
    capsys.readouterr()
    assert run(["next", str(recorded)]) == 0  # what the diagnosis has proposed
    assert kept.next_measurement.why.rstrip(".") in capsys.readouterr().out
    asked = []
    keep_diagnosis(recorded, replace(kept, next_measurement=None))

    def find(_measurements, between, _options):
        asked.append(between)
        return kept.next_measurement

    monkeypatch.setattr(model.discrepancy, "next_measurement", find)
    assert run(["next", str(recorded)]) == 0
    assert asked == [("nonuniform_eibm", "load_cell_hysteresis")]


@pytest.mark.slow
def test_next_and_the_diagnosis_give_one_distance_for_a_pair(finding, recorded, capsys):
    finding(made.indistinguishable)
    assert run(["diagnose", str(recorded)]) == 0
    capsys.readouterr()
    pair = ["load_cell_hysteresis", "nonuniform_eibm"]
    assert run(["next", str(recorded), "--between", *pair, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["separation_now"], found["separation_expected"]) == (1.8, 14.0)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_measurement_made_as_proposed_is_compared_with_its_promise(finding, tmp_path, capsys):
    first = session(tmp_path / "first.h5", measure("long"))
    asked = finding(made.indistinguishable)
    assert run(["diagnose", str(first)]) == 0
    text = tmp_path / "protocol.toml"
    assert run(["next", str(first), "-o", str(text)]) == 0
    other = session(tmp_path / "other.h5", measure("long"))
    assert run(["diagnose", str(first), str(other)]) == 0
    assert asked[-1].promised == ()  # another protocol was run
    second = session(
        tmp_path / "second.h5", measure("long"), texts={**TEXTS, "protocol.toml": text.read_text()}
    )
    assert run(["diagnose", str(first), str(second)]) == 0
    (promise,) = asked[-1].promised
    assert promise.expected == 14.0
    kept = replace(
        made.indistinguishable(), next_measurement=None, promises=(Promise(promise, 4.8),)
    )
    finding(lambda: kept)
    capsys.readouterr()
    assert run(["diagnose", str(first), str(second), "--json"]) == 0
    (said,) = json.loads(capsys.readouterr().out)["promises"]
    assert (said["separation_promised"], said["separation_found"]) == (14.0, 4.8)
    assert run(["diagnose", str(first), str(second)]) == 0
    assert asked[-1].promised == (promise,)  # a promise stays with the session


@pytest.mark.slow
def test_next_after_no_verdict_says_why_there_is_none(finding, recorded, capsys):
    why = "These data do not allow a verdict: there is one set-up of the load cell."
    finding(lambda: replace(made.nothing_missing(), verdict="cannot_tell", sentence=why))
    assert run(["diagnose", str(recorded)]) == 0
    capsys.readouterr()
    assert run(["next", str(recorded)]) == 2
    assert why in " ".join(capsys.readouterr().err.split())


@pytest.mark.slow
def test_next_says_so_where_nothing_needs_to_be_told_apart(finding, recorded, capsys):
    finding(made.nothing_missing)
    assert run(["diagnose", str(recorded)]) == 0
    assert run(["next", str(recorded)]) == 2
    assert "names no two effects that could be mistaken" in " ".join(
        capsys.readouterr().err.split()
    )


@pytest.mark.slow
def test_the_hint_at_the_next_measurement_is_a_command_that_works(finding, recorded, capsys):
    finding(made.indistinguishable)
    assert run(["diagnose", str(recorded)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    hint = said[said.index("labrig next ") :].split(" -o protocol.toml")[0]
    words = shlex.split(hint)
    assert words[:2] == ["labrig", "next"]
    assert run(words[1:]) == 0


@pytest.mark.thorough
@pytest.mark.slow
def test_next_diagnoses_first_what_was_not_diagnosed_yet(finding, tmp_path, capsys):
    path = session(tmp_path / "new.h5", measure("long"))
    asked = finding(made.indistinguishable)
    assert kept_diagnosis(path) is None
    assert run(["next", str(path)]) == 0
    assert len(asked) == 1
    found = capsys.readouterr()
    assert "holds no diagnosis yet, so it is diagnosed first" in " ".join(found.err.split())
    assert kept_diagnosis(path).next_measurement.why.rstrip(".") in found.out
    assert run(["next", str(path)]) == 0
    assert len(asked) == 1

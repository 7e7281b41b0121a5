"""What is known of a strip: one file for each kind of fact, also of another distribution."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.testing import strip_fact_faults
from labrig.vision import Optics
from labrig.vision.calibration.optics import StripPlace
from labrig.vision.facts import stated
from labrig.vision.facts.catalogue import strip_facts
from labrig.vision.facts.conformance import KEYS_OF_OPTICS, faults
from labrig.vision.facts.contract import (
    FactOf,
    FactOption,
    FactShape,
    FactTool,
    SearchConstraints,
    StripFact,
    objection,
)
from tests.labrig.vision import drawn_strips

PAGE = Path(__file__).parents[3] / "docs" / "howto" / "extending.md"
KNOWN = {"px_per_mm": 2.0, "clamp_px": (30.0, 110.0)}
FOREIGN = '''
"""Where a strip runs and ends, in one option; and facts that are at fault."""

from dataclasses import dataclass, replace

from labrig.vision.facts.contract import FactOption, FactShape, StripFact, SearchConstraints


@dataclass(frozen=True, kw_only=True)
class Course(StripFact):
    def constraints(self, value):
        *through, tip = value
        return SearchConstraints(through_px=tuple(through), tip_px=tip)


class Broken(Course):
    def read(self, stated):
        if stated == "1":
            raise ValueError("give more than that.")
        return {}["no such thing"] if stated != self.example else super().read(stated)


FACT = Course(name="course_px", meaning="the whole course", shape=FactShape.POINTS, example="1,2",
              option=FactOption(flag="--course", help="'U,V U,V ...': all along it"), order=45)
BROKEN = Broken(name="broken_px", meaning="it", shape=FactShape.POINTS, example="3,4",
                option=FactOption(flag="--broken", help="it"), order=60)
TAKEN = replace(FACT, name="taken_px", option=FactOption(flag="--sheet", help="it"))
SILENT = StripFact(name="silent", meaning="it", shape=FactShape.FLAG, order=1,
                   option=FactOption(flag="--silent", help="it"))
'''


def shown_on_the_page() -> str:
    section = PAGE.read_text(encoding="utf-8").split("## A strip fact")[1]
    return section.split("```python")[1].split("```")[0]


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Add a distribution with facts; the command is made anew with their options."""

    def add(code: str, **facts: str) -> None:
        info = tmp_path / "site" / "labrig_strange-0.3.dist-info"
        info.mkdir(parents=True)
        (tmp_path / "site" / "labrig_strange.py").write_text(code)
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: labrig-strange\nVersion: 0.3")
        points = [f"{name} = labrig_strange:{constant}" for name, constant in facts.items()]
        (info / "entry_points.txt").write_text("\n".join(["[labrig.strip_facts]", *points]))
        monkeypatch.syspath_prepend(str(tmp_path / "site"))
        for module in ("labrig_strange", "labrig.cli.commands.curves"):
            monkeypatch.delitem(sys.modules, module, raising=False)

    return add


@pytest.fixture
def photograph(tmp_path):
    return drawn_strips.write(tmp_path / "photographs", drawn_strips.BENT_UP.image)


def pixels(*shares: float) -> str:
    return " ".join("{},{}".format(*drawn_strips.place_on_it(share)) for share in shares)


@pytest.mark.parametrize("name", strip_facts())
def test_each_fact_conforms(name):
    assert faults(strip_facts()[name]) == []
    assert strip_facts()[name].name == name


def test_the_orders_of_the_options_differ():
    orders = [fact.order for fact in strip_facts().values()]
    assert orders == sorted(set(orders))


def test_a_faulty_fact_is_told_what_is_wrong():
    assert faults("fact") == ["it is of type str, not a StripFact"]
    option = FactOption(flag="wall", help="")
    tool = FactTool(label="x", hint="x.", noun="x")
    bad = StripFact(
        name="a fact", meaning="", shape=FactShape.OTHER, option=option, tool=tool, order=1
    )
    assert len(faults(bad)) == 6
    silent = StripFact(
        name="silent",
        meaning="it",
        shape=FactShape.FLAG,
        option=FactOption(flag="--silent", help="it"),
        order=1,
    )
    assert faults(silent) == ["it has neither `constraints` nor `directed`: it says nothing"]


def test_no_fact_has_the_name_of_another_key_of_optics_json():
    fields = Optics.model_fields.keys() | StripPlace.model_fields.keys()
    assert fields - {"along_px"} == KEYS_OF_OPTICS
    channel = replace(strip_facts()["tip_px"], name="channel")
    assert faults(channel) == ["its name 'channel' is a key of optics.json already"]


def test_what_facts_tell_is_put_together():
    tips = SearchConstraints.together(
        [
            SearchConstraints(tip_px=(1.0, 2.0)),
            SearchConstraints(tip_px=(3.0, 4.0), through_px=((5, 6),)),
        ]
    )
    assert tips.tip_px == (1.0, 2.0)
    assert tips.through_px == ((5, 6),)
    assert tips.length_measured
    assert not SearchConstraints.together([]).length_measured


def test_a_file_with_facts_is_read_and_written_as_it_was():
    polygons = [[[1.0, 2.0], [3.0, 4.0], [5.0, 7.0]]]
    facts = {"through_px": [[40.0, 100.0]], "tip_px": [90.0, 60.0], "mask_px": polygons}
    optics = Optics.from_json(json.dumps(KNOWN | facts))
    assert optics.tip_px == (90.0, 60.0)
    assert optics.through_px == ((40.0, 100.0),)
    assert optics.mask_px == (((1.0, 2.0), (3.0, 4.0), (5.0, 7.0)),)
    written = json.loads(optics.to_json())
    assert {key: written[key] for key in facts} == facts
    assert "facts" not in written
    assert Optics.from_json(optics.to_json()) == optics
    assert hash(Optics.from_json(optics.to_json())) == hash(optics)
    without = optics.model_copy(update={"tip_px": None, "through_px": ((1.0, 2.0),)})
    assert (without.tip_px, without.through_px) == (None, ((1.0, 2.0),))
    assert without.mask_px == optics.mask_px


def test_facts_of_a_strip_are_its_own_and_those_of_the_pictures_are_everybodys():
    mask = (((1.0, 2.0), (3.0, 4.0), (5.0, 7.0)),)
    strips = {"a": StripPlace(clamp_px=(1, 2), tip_px=(8, 9)), "b": StripPlace(clamp_px=(3, 4))}
    optics = Optics(**KNOWN, mask_px=mask, strips=strips, to_end=True)
    a, b = optics.by_strip().values()
    assert (a.tip_px, b.tip_px) == ((8.0, 9.0), None)
    assert a.mask_px == b.mask_px == mask
    assert b.constraints.length_measured
    kept = optics.without_places()
    assert kept.by_strip()["a"].tip_px is None
    assert kept.mask_px == mask


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"tip_px": "left"}, "tip_px: give a pixel as [column, row]."),
        ({"tip_px": [10**400, 1]}, "tip_px: give a pixel as [column, row]."),
        ({"through_px": [3, 4]}, "through_px: give pixels as a list of [column, row]."),
        ({"through_px": [[1, 2]] * 101}, "through_px: give at most 100 pixels."),
        ({"mask_px": [[[1, 2], [3, 4]]]}, "mask_px: give polygons, each a list of at least three"),
        ({"to_end": False}, "to_end: give true, or leave it out."),
        ({"facts": {}}, "facts is not a known key"),
        ({"along_px": [3, 4]}, "along_px is not a known key"),
        ({"tip_pix": [3, 4]}, "tip_pix is not a known key; did you mean tip_px"),
        ({"wall_px": [[3, 4]]}, "did you mean rolls_px, or a fact of a distribution that is not"),
        ({"strips": {"a": {"clamp_px": [1, 2], "mask_px": []}}}, "mask_px is not a known key"),
    ],
)
def test_what_cannot_be_a_fact_is_said_in_one_sentence(more, said):
    with pytest.raises(BadInputError) as fault:
        Optics.from_json(json.dumps(KNOWN | more))
    assert said in str(fault.value)
    assert "\n" not in str(fault.value)


def test_a_mask_may_have_more_corners_than_a_file_name_has_letters():
    corners = [(float(u), 10.5) for u in range(100)]
    stated = " ".join(f"{u},{v}" for u, v in corners)
    assert strip_facts()["mask_px"].read(stated) == (tuple(corners),)


def test_the_fact_on_the_page_about_extending_conforms():
    there: dict[str, object] = {"__name__": "example"}
    exec(compile(shown_on_the_page(), "extending.md", "exec"), there)
    assert faults(there["FACT"]) == []


def test_a_fact_of_one_strip_is_refused_on_the_command_line_where_the_file_has_several(
    photograph, capsys
):
    strips = {"a": {"clamp_px": [30.0, 110.0]}, "b": {"clamp_px": [30.0, 150.0]}}
    drawn_strips.write(photograph.parent, drawn_strips.BENT_UP.image, strips=strips, to_end=True)
    assert run(["curves", str(photograph), "--tip-px", "90,40"]) == 2
    said = capsys.readouterr().err
    assert "--tip-px: optics.json has several strips; state tip_px in the entry of one" in said
    assert "(a and b)." in said


@pytest.mark.slow
def test_a_fact_of_another_distribution_is_stated_on_the_command_line(install, photograph, capsys):
    ours = ["--through", pixels(0.3, 0.6), "--tip-px", pixels(0.98)]
    assert run(["curves", str(photograph), "--json", *ours]) == 0
    expected = json.loads(capsys.readouterr().out)
    assert expected["ok"]
    install(FOREIGN, course_px="FACT")
    course = ["--course", pixels(0.3, 0.6, 0.98)]
    assert run(["curves", str(photograph), "--json", *course]) == 0
    assert json.loads(capsys.readouterr().out) == expected
    assert run(["curves", "--help"]) == 0
    assert "--course" in capsys.readouterr().out
    assert run(["curves", str(photograph), "--strip", "a=1,2", *course]) == 2
    assert "--through, --tip-px and --course are for one strip" in capsys.readouterr().err

    # as a key of the file, and scaled with the picture
    places = [list(drawn_strips.place_on_it(share)) for share in (0.3, 0.6, 0.98)]
    drawn_strips.write(photograph.parent, drawn_strips.BENT_UP.image, course_px=places)
    assert run(["curves", str(photograph), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == expected


@pytest.mark.slow
def test_the_fact_of_the_page_objects_to_a_curve_that_crosses_its_wall(install, photograph, capsys):
    install(shown_on_the_page(), wall_px="FACT")
    u, v = drawn_strips.place_on_it(0.5)
    away = ["--wall", f"{u},{v + 40} {u + 60},{v + 40}"]
    assert run(["curves", str(photograph), *away]) == 0
    assert "no curve" not in capsys.readouterr().out
    across = ["--wall", f"{u},{v - 20} {u},{v + 20}"]
    assert run(["curves", str(photograph), *across]) == 0
    said = capsys.readouterr().out
    assert "no curve: check of what is known failed: the curve crosses the wall near" in said


def test_facts_of_another_distribution_are_listed_and_named_in_errors(install, photograph, capsys):
    install(FOREIGN, course_px="FACT", broken_px="BROKEN", silent="SILENT")
    with pytest.warns(UserWarning, match="'silent' of labrig-strange .* is left out: .* nothing"):
        strip_facts()
    assert run(["parts", "strip_facts"]) == 0
    assert "course_px" in (listed := capsys.readouterr().out)
    assert "labrig-strange" in listed
    assert run(["curves", str(photograph), "--course", "12;13"]) == 2
    assert "--course '12;13': give columns and rows of pixels" in capsys.readouterr().err
    assert run(["curves", str(photograph), "--broken", "1"]) == 2
    assert "--broken '1': give more than that." in capsys.readouterr().err
    assert run(["curves", str(photograph), "--broken", "5,6"]) == 2
    said = capsys.readouterr().err
    assert "'broken_px' of labrig-strange 0.3 failed with KeyError" in said
    assert "\n" not in said.strip()


@pytest.mark.filterwarnings("default")
def test_a_fact_whose_option_is_taken_is_left_out(install, photograph, capsys):
    install(FOREIGN, taken_px="TAKEN")
    assert run(["curves", "--help"]) == 0
    said = " ".join(capsys.readouterr().err.split())
    assert "the strip fact 'taken_px' of labrig-strange 0.3 is left out: labrig curves" in said


def test_of_two_facts_of_one_name_the_second_is_left_out_with_a_sentence(install):
    install(FOREIGN.replace('name="course_px"', 'name="tip_px"'), another="FACT")
    with pytest.warns(UserWarning, match="'tip_px' of labrig-strange is left out: there is one"):
        assert strip_facts()["tip_px"].option.flag == "--tip-px"


OBJECTS = """

class Objects(Course):
    def constraints(self, value):
        return SearchConstraints(objections=OBJECTIONS)


def once_shown(answer):
    drawn = []

    def objection(points):
        if not drawn:  # the drawn curve, when it is loaded
            return drawn.append(points) or ""
        return answer(points)

    return objection


OBJECTION = Objects(name="clip_px", meaning="it", shape=FactShape.POINTS, example="1,2",
                    option=FactOption(flag="--clip", help="it"), order=50)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ("lambda points: 1 / 0", "ZeroDivisionError: division by zero"),
        ("lambda points: points @ points", "ValueError: matmul"),
        ("lambda points: True", "its objection returned True, not a text"),
    ],
)
def test_a_stated_fact_that_cannot_be_compared_with_the_curve_refuses_it(
    install, photograph, capsys, answer, said
):
    code = OBJECTS.replace("OBJECTIONS", "(shown,)") + f"shown = once_shown({answer})"
    install(FOREIGN + code, clip_px="OBJECTION")
    assert run(["curves", str(photograph), "--json", "--clip", "3,4"]) == 0
    curve = json.loads(capsys.readouterr().out)
    assert not curve["ok"]
    start = "check of what is known failed: clip_px: the strip fact 'clip_px' of labrig-strange 0.3"
    assert curve["why"].startswith(start)
    assert said in curve["why"]
    assert "leave --clip out" in curve["why"]


@pytest.mark.parametrize(
    ("objections", "said"),
    [
        ("(lambda points: 1 / 0,)", "its objection failed with ZeroDivisionError"),
        ("(lambda points: True,)", "its objection returned True, not a text"),
        ("lambda points: ''", "its objections are a function, not a tuple of functions"),
        ("('no',)", "its objections are not functions"),
    ],
)
def test_an_objection_is_asked_about_a_drawn_curve_before_anybody_uses_it(
    install, objections, said
):
    install(FOREIGN + OBJECTS.replace("OBJECTIONS", objections), clip_px="OBJECTION")
    with pytest.warns(UserWarning, match="'clip_px' of labrig-strange .* is left out") as caught:
        strip_facts()
    assert said in str(caught[0].message)


def test_an_objection_that_writes_into_its_points_moves_no_curve():
    def from_the_wall(points):
        points -= np.array([100.0, 20.0])
        return ""

    curve = np.array([[30.0, 110.0], [60.0, 108.0]])
    assert objection(from_the_wall, curve) == ""
    assert curve.tolist() == [[30.0, 110.0], [60.0, 108.0]]


def test_what_an_objection_of_ours_raises_is_a_fault_of_ours():
    class Failing(StripFact):
        def constraints(self, value):
            return SearchConstraints(objections=(lambda points: {}[value],))

    tip = strip_facts()["tip_px"]
    ours = Failing(**{field: getattr(tip, field) for field in vars(tip)})
    (objects,) = stated._constraints(ours, (1.0, 2.0)).objections
    with pytest.raises(KeyError):
        objects(np.zeros((2, 2)))


@pytest.mark.parametrize(
    ("fact", "said"),
    [
        ({"example": "100;90"}, "its example '100;90' is not read: give a pixel's column and row"),
        ({"option": FactOption(flag=3, help="it")}, "its code raised TypeError"),
    ],
)
def test_the_conformance_of_a_fact_is_told_in_sentences(fact, said):
    (fault,) = strip_fact_faults(replace(strip_facts()["tip_px"], **fact))
    assert said in fault


def test_places_follow_a_picture_that_is_reduced():
    from labrig.vision.image.downscaling import downscaled_optics

    optics = Optics(**KNOWN, tip_px=(90.5, 60.5), through_px=((0.5, 0.5),))
    small = downscaled_optics(optics, 2)
    assert small.tip_px == (45.0, 30.0)
    assert small.through_px == ((0.0, 0.0),)
    assert optics.facts_that_are(FactOf.STRIP).keys() == {"through_px", "tip_px"}
    assert np.isfinite(small.px_per_mm)

"""A folder of photographs behind its page: what is clicked stays beside them and is used again."""

from __future__ import annotations

import json
import re
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.panel.errors import MissingError
from labrig.panel.pages.photographs import KnownBody
from labrig.panel.photographs.folder import PhotographFolder
from labrig.panel.photographs.known import Clicked, changed_optics
from labrig.panel.photographs.photograph import Photograph
from labrig.vision import NeutralCurve, load_optics, write_overlay
from labrig.vision.calibration.optics import StripPlace
from labrig.vision.image.names import PictureLabel
from labrig.vision.image.overlay import LONG_SIDE_PX
from tests.labrig.vision import drawn_strips
from tests.labrig.vision.drawn_strips import BENT_UP

pytestmark = pytest.mark.slow  # photographs are measured
CLAMP = BENT_UP.optics.clamp_px
SIZE = (BENT_UP.image.shape[1], BENT_UP.image.shape[0])
PLACE = StripPlace(clamp_px=CLAMP, along_px=(CLAMP[0] + 60, CLAMP[1]))
RULER = {"ruler_px": ((24.0, 20.0), (144.0, 20.0)), "ruler_mm": 30.0}
LENGTHS = {"lengths_mm": {"free_length_mm": 30.0, "thickness_mm": 0.6}}


def clicked(**more: object) -> Clicked:
    return Clicked(**({"strips": {"": PLACE}} | RULER | LENGTHS | more))  # type: ignore[arg-type]


def measured(folder: PhotographFolder) -> dict[str, dict[str, object]]:
    """What all photographs show once none waits."""
    end_s = time.monotonic() + 60
    while folder.listing(0)["waiting"]:
        assert time.monotonic() < end_s
        folder.thread.join(0.01)
    return {one["name"]: one for one in folder.listing(0)["photographs"]}


@pytest.fixture
def photographs(tmp_path: Path):
    """Two photographs of which nothing is known, and a file that is none."""
    for name in ("a", "b"):
        cv2.imwrite(str(tmp_path / f"{name}.png"), BENT_UP.image)
    (tmp_path / "damaged.png").write_bytes(b"nothing")
    opened = PhotographFolder(tmp_path)
    yield opened
    opened.close()


def test_what_is_clicked_once_serves_all_and_the_command_line(photographs, capsys):
    states = {name: one["state"] for name, one in measured(photographs).items()}
    assert states == {"a": "new", "b": "new", "damaged": "unreadable"}
    done = photographs.set_known("a", clicked(), for_all=True)
    assert done["written"] == ["optics.json", "sheet.toml"]
    states = {name: one["state"] for name, one in measured(photographs).items()}
    assert states == {"a": "found", "b": "found", "damaged": "unreadable"}
    (curve,) = photographs.details("b")["curves"]
    assert drawn_strips.off_px(curve["points_px"], BENT_UP) < 0.3
    assert cv2.imdecode(np.frombuffer(photographs.thumbnail("b"), np.uint8), 1).shape[1] == 320
    assert run(["curves", str(photographs.folder / "b.png"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["points_px"] == pytest.approx(
        np.array(curve["points_px"]), abs=0.01
    )


def test_the_size_that_clicks_are_counted_in_is_known_before_a_photograph_is_measured(tmp_path):
    cv2.imwrite(str(tmp_path / "large.png"), np.full((1500, 3000), 90, np.uint8))
    opened = PhotographFolder(tmp_path)
    opened.close()  # so that nothing is measured
    assert opened.details("large")["size"] == [3000, 1500]


def test_a_correction_of_one_photograph_is_its_own_and_leaves_the_others(photographs):
    photographs.set_known("a", clicked(), for_all=True)
    before = measured(photographs)
    mask = ((100.0, 100.0), (150.0, 100.0), (150.0, 140.0))
    only = Clicked(strips={"": PLACE}, facts={"mask_px": (mask,)})
    assert photographs.set_known("a", only, for_all=False)["written"] == ["a.optics.json"]
    after = measured(photographs)
    assert after["a"]["own"]
    assert not after["b"]["own"]
    assert after["b"]["revision"] == before["b"]["revision"]
    assert photographs.details("a")["known"]["mask_px"] == (mask,)
    assert photographs.details("a")["known"]["px_per_mm"] == pytest.approx(4.0)
    assert photographs.details("b")["known"]["mask_px"] == ()


def test_places_on_a_strip_are_one_photographs_own(photographs):
    tip, middle = drawn_strips.place_on_it(1.0), drawn_strips.place_on_it(0.5)
    places = {"through_px": (middle,), "tip_px": tip}
    there = {"": PLACE.model_copy(update=places)}
    done = photographs.set_known("a", clicked(strips=there), for_all=True)
    assert done["written"] == ["optics.json", "sheet.toml", "a.optics.json"]
    common = json.loads((photographs.folder / "optics.json").read_text())
    assert not {"tip_px", "through_px"} & set(common)
    shown = measured(photographs)
    assert shown["a"]["state"] == shown["b"]["state"] == "found"
    assert shown["a"]["own"]
    assert not shown["b"]["own"]
    assert any("to the stated tip" in text for text in shown["a"]["warnings"])
    known = photographs.details("a")["known"]["strips"][""]
    assert known["tip_px"] == tip
    assert known["through_px"] == (middle,)
    taken_back = clicked(strips={"": PLACE}, ruler_px=None, ruler_mm=None)
    photographs.set_known("a", taken_back, for_all=False)
    assert measured(photographs)["a"]["warnings"] == shown["b"]["warnings"]


def test_with_its_tip_a_strip_needs_no_length(photographs):
    tip = drawn_strips.place_on_it(1.0)
    there = {"": PLACE.model_copy(update={"tip_px": tip})}
    with pytest.raises(BadInputError, match="or click the tip"):
        photographs.set_known("a", clicked(strips={"": PLACE}, lengths_mm=None), for_all=False)
    photographs.set_known("a", clicked(strips=there, lengths_mm=None), for_all=False)
    assert measured(photographs)["a"]["state"] == "found"


def test_decisions_are_kept_and_a_refused_photograph_has_no_curve_anywhere(photographs, capsys):
    photographs.set_known("a", clicked(), for_all=True)
    measured(photographs)
    photographs.decide(["a"], "accepted", "Ann", "")
    photographs.decide(["b"], "refused", "Ann", "it swings")
    again = PhotographFolder(photographs.folder)
    shown = measured(again)
    assert (shown["a"]["decision"], shown["b"]["decision"]) == ("accepted", "refused")
    assert run(["curves", str(again.folder / "b.png"), "--json"]) == 0
    why = json.loads(capsys.readouterr().out)["why"]
    assert why.startswith("refused by hand by Ann, ")
    assert "it swings" in why
    again.decide(["b"], "none", "Ann", "")
    assert measured(again)["b"]["state"] == "found"
    again.close()


def test_an_accepted_curve_that_is_made_from_something_else_is_to_be_looked_at_again(photographs):
    photographs.set_known("a", clicked(), for_all=True)
    measured(photographs)
    photographs.decide(["a", "b"], "accepted", "Ann", "")
    moved = StripPlace(clamp_px=(CLAMP[0] + 1, CLAMP[1]), along_px=PLACE.along_px)
    photographs.set_known("a", Clicked(strips={"": moved}), for_all=False)
    shown = measured(photographs)
    assert (shown["a"]["decision"], shown["b"]["decision"]) == (None, "accepted")
    assert list(
        json.loads((photographs.folder / "curves_review.json").read_text())["pictures"]
    ) == ["b"]


def test_a_photograph_that_is_replaced_is_measured_and_looked_at_again(photographs):
    photographs.set_known("a", clicked(), for_all=True)
    measured(photographs)
    photographs.decide(["a", "b"], "accepted", "Ann", "")
    cv2.imwrite(str(photographs.folder / "a.png"), BENT_UP.image // 2 + 60)
    with pytest.raises(BadInputError, match=r"^a\.png: changed since measured"):
        photographs.write_tables()
    shown = measured(photographs)
    assert (shown["a"]["decision"], shown["b"]["decision"]) == (None, "accepted")
    photographs.write_tables()
    (photographs.folder / "b.png").unlink()
    with pytest.raises(BadInputError, match=r"^b\.png: changed since measured"):
        photographs.write_tables()
    assert measured(photographs)["b"]["state"] == "unreadable"
    photographs.write_tables()
    assert "no such file" in (photographs.folder / "curves" / "summary.csv").read_text()


def test_a_photograph_that_comes_while_the_page_is_open_is_taken_in_once_it_is_whole(photographs):
    measured(photographs)
    photographs.set_known("a", clicked(), for_all=True)
    measured(photographs)
    late = photographs.folder / "late.png"
    whole = cv2.imencode(".png", BENT_UP.image)[1].tobytes()
    late.write_bytes(whole[: len(whole) // 2])
    assert photographs.listing(0)["total"] == 3
    late.write_bytes(whole)  # the copy is complete
    assert photographs.listing(0)["total"] == 3
    assert photographs.listing(0)["total"] == 4
    assert measured(photographs)["late"]["state"] == "found"
    assert photographs.listing(0)["total"] == 4


def test_a_direction_that_is_not_known_is_not_shown_and_stays_so_until_it_is_clicked(tmp_path):
    drawn_strips.write(tmp_path, BENT_UP.image, "a", clamp_angle_known=False)
    opened = PhotographFolder(tmp_path)
    place = StripPlace(**opened.details("a")["known"]["strips"][""])
    assert place.along_px is None
    tip = place.model_copy(update={"tip_px": drawn_strips.place_on_it(1.0)})
    opened.set_known("a", Clicked(strips={"": tip}), for_all=True)
    assert not load_optics(tmp_path / "optics.json").clamp_angle_known
    ahead = tip.model_copy(update={"along_px": (CLAMP[0] + 60, CLAMP[1])})
    opened.set_known("a", Clicked(strips={"": ahead}), for_all=True)
    assert load_optics(tmp_path / "optics.json").clamp_angle_known
    opened.close()


def test_two_files_of_the_users_own_are_kept_also_where_their_day_is_the_same(tmp_path):
    """As on a computer whose clock begins anew in 1970."""
    written = set[str]()
    for sigma in (0.01, 0.02):
        drawn_strips.write(tmp_path, BENT_UP.image, "a", px_per_mm_sigma=sigma)
        written.add((tmp_path / "optics.json").read_text())
        moved = StripPlace(clamp_px=(CLAMP[0] + 1, CLAMP[1]), along_px=PLACE.along_px)
        opened = PhotographFolder(tmp_path)
        opened.set_known("a", Clicked(strips={"": moved}), for_all=True)
        opened.close()
    assert {kept.read_text() for kept in tmp_path.glob("optics.json.*.bak")} == written


def test_a_file_of_the_users_own_is_kept_and_only_changed_where_something_was_clicked(tmp_path):
    drawn_strips.write(tmp_path, BENT_UP.image, "a", polarity="bright", px_per_mm_sigma=0.01)
    before = (tmp_path / "optics.json").read_text()
    opened = PhotographFolder(tmp_path)
    place = opened.details("a")["known"]["strips"][""]
    mask = ((1.0, 1.0), (9.0, 1.0), (9.0, 9.0))
    same = Clicked(strips={"": StripPlace(**place)}, facts={"mask_px": (mask,)})
    opened.set_known("a", same, for_all=True)
    known = json.loads((tmp_path / "optics.json").read_text())
    assert (known["polarity"], known["px_per_mm_sigma"]) == ("bright", 0.01)
    (kept,) = tmp_path.glob("optics.json.*.bak")
    assert json.loads(kept.read_text()) == json.loads(before)
    # the clamp and its direction are as they were known: a mask makes them no worse
    assert known.get("clamp_sigma_px", 1.0) == BENT_UP.optics.clamp_sigma_px
    moved = StripPlace(clamp_px=(CLAMP[0] + 1, CLAMP[1]), along_px=PLACE.along_px)
    opened.set_known("a", Clicked(strips={"": moved}), for_all=True)
    assert json.loads((tmp_path / "optics.json").read_text())["clamp_sigma_px"] == 2.0
    opened.close()


def test_several_strips_and_the_pages_of_a_tiff_have_their_curves(tmp_path):
    both = drawn_strips.side_by_side()
    assert cv2.imwritemulti(str(tmp_path / "stack.tif"), [both, both])
    opened = PhotographFolder(tmp_path)
    right = StripPlace(clamp_px=(CLAMP[0] + 200, CLAMP[1]), along_px=(CLAMP[0] + 260, CLAMP[1]))
    opened.set_known("stack:1", clicked(strips={"left": PLACE, "right": right}), for_all=True)
    assert {name: one["state"] for name, one in measured(opened).items()} == {
        "stack:1": "found", "stack:2": "found",
    }  # fmt: skip
    assert [curve["strip"] for curve in opened.details("stack:2")["curves"]] == ["left", "right"]
    assert opened.write_tables() == ["curves/curves.csv", "curves/summary.csv"]
    lines = (tmp_path / "curves" / "summary.csv").read_text().splitlines()
    assert [line.partition(",")[0] for line in lines[1:]] == [
        "stack:1:left", "stack:1:right", "stack:2:left", "stack:2:right",
    ]  # fmt: skip
    opened.close()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"strips": {}}, "the clamp is missing"),
        ({"ruler_px": None}, "the scale is missing"),
        ({"ruler_mm": None}, "the ruler's length is missing"),
        ({"strips": {"": StripPlace(clamp_px=(900.0, 5.0))}}, "the clamp lies outside"),
        ({"ruler_px": ((1.0, 1.0), (2.0, 1.0))}, "at least 20 pixels apart"),
    ],
)
def test_what_is_missing_is_said(change, said):
    with pytest.raises(BadInputError, match=said):
        changed_optics(None, SIZE, clicked(**change))


def test_what_cannot_be_decided_or_found_is_said(photographs):
    measured(photographs)
    with pytest.raises(BadInputError, match="a: has no curve that could be accepted"):
        photographs.decide(["a"], "accepted", "Ann", "")
    with pytest.raises(MissingError, match="no such photograph"):
        photographs.details("../a")
    with pytest.raises(BadInputError, match="free length is missing"):
        photographs.set_known("a", clicked(lengths_mm=None), for_all=True)
    assert not (photographs.folder / "optics.json").exists()


@pytest.mark.parametrize("size", [(20, 16), (480, 640), (3000, 4000), (60, 3000)])
def test_an_overlay_is_readable_on_a_picture_of_any_size(tmp_path, size):
    line = np.linspace((0.0, 0.0), (size[1] - 1.0, size[0] - 1.0), 50)
    curve = NeutralCurve(ok=True, points_px=line, seen=np.ones(50, dtype=bool), covered=0.9)
    write_overlay(tmp_path / "o.png", np.full(size, 90, np.uint8), curve)
    drawn = cv2.imread(str(tmp_path / "o.png"))
    low, high = LONG_SIDE_PX
    assert low <= max(drawn.shape[:2]) <= high + 120
    assert drawn.shape[1] >= 480
    red = (drawn[..., 2] > 200) & (drawn[..., 1] < 120)
    green = (drawn[..., 1] > 200) & (drawn[..., 2] < 140)
    assert red.sum() > 500
    assert green.sum() > 100  # the text


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (["nowhere"], "there is no such folder"),
        ([".", "--summary", "s.csv"], "takes no images"),
        ([".", "--extractor", "intensity_fit"], "the built-in extractor finds their curves"),
    ],
)
def test_a_wrong_start_of_the_page_is_one_sentence(asked, said, capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert run(["curves", "--page", *asked]) == 2
    assert said in capsys.readouterr().err


def test_a_damaged_review_is_told_at_the_start(tmp_path, capsys):
    (tmp_path / "curves_review.json").write_text('{"pictures": {"a": {"decision": "maybe"}}}')
    assert run(["curves", "--page", str(tmp_path)]) == 2
    assert "curves_review.json" in capsys.readouterr().err


def test_of_several_strips_each_keeps_its_own_tip(tmp_path):
    cv2.imwrite(str(tmp_path / "both.png"), drawn_strips.side_by_side())
    opened = PhotographFolder(tmp_path)
    left = PLACE.model_copy(update={"tip_px": (200.0, 90.0)})
    right = StripPlace(clamp_px=(CLAMP[0] + 200, CLAMP[1]), tip_px=(390.0, 130.0))
    opened.set_known("both", clicked(strips={"left": left, "right": right}), for_all=False)
    opened.close()
    known = load_optics(tmp_path / "both.optics.json").by_strip()
    assert {name: of.tip_px for name, of in known.items()} == {
        "left": (200.0, 90.0), "right": (390.0, 130.0),
    }  # fmt: skip
    shown = opened.details("both")
    assert shown["known"]["strips"]["left"]["tip_px"] == (200.0, 90.0)
    assert shown["known"]["strips"]["right"]["through_px"] == ()
    assert [(tool["key"], tool["of"], tool["shape"]) for tool in shown["tools"]] == [
        ("through_px", "strip", "points"),
        ("tip_px", "strip", "point"),
        ("mask_px", "picture", "polygons"),
    ]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"nonsense": 1}, "nonsense is nothing that can be clicked."),
        ({"mask_px": [[[1, 2]]]}, "mask_px: give polygons, each a list of at least three"),
        ({"clamp": {"clamp_px": [1, 2], "tip_px": [3]}}, "tip_px: give a pixel as"),
        ({"clamp": {"clamp_px": [1, 2], "mask_px": [[[1, 2]]]}}, "mask_px is nothing that can be"),
    ],
)
def test_what_is_sent_and_no_fact_is_named(more, said):
    with pytest.raises(BadInputError, match=re.escape(said)):
        KnownBody(name="a", **more).clicked()


def test_sentences_name_the_tools_of_the_page_and_the_strips():
    why = "it is hidden; state places there (--through) or its tip (--tip-px), or mask (--mask)."
    curves = [
        ("up", NeutralCurve(ok=False, why=why)),
        ("low", NeutralCurve(ok=False, why="it is dark; check --along-px.", warnings=("dim",))),
    ]
    label = PictureLabel(name="a", file_stem="a")
    one = Photograph(label=label, path=Path("a.png"), curves=curves, why=why)
    message = one.message()
    assert message["why"] == (
        "it is hidden; state places there (On the strip) or its tip (Tip), or mask (Mask)."
    )
    assert message["warnings"] == ["low: dim"]
    assert [each["why"] for each in one.curve_messages()] == [
        message["why"], "it is dark; check Direction.",
    ]  # fmt: skip
    assert one.rows()[0][1].why == why  # a table is for the command's users, too


def test_photographs_of_one_name_are_both_shown_and_each_keeps_its_clicks(tmp_path):
    for name in ("same.png", "same.bmp"):
        cv2.imwrite(str(tmp_path / name), BENT_UP.image)
    opened = PhotographFolder(tmp_path)
    assert list(measured(opened)) == ["same.bmp", "same.png"]
    opened.set_known("same.bmp", clicked(), for_all=True)
    only = Clicked(strips={"": PLACE}, facts={"mask_px": (((1.0, 1.0), (9.0, 1.0), (9.0, 9.0)),)})
    done = opened.set_known("same.png", only, for_all=False)
    assert done["written"] == ["same.png.optics.json"]
    shown = measured(opened)
    assert [(one["state"], one["own"]) for one in shown.values()] == [
        ("found", False),
        ("found", True),
    ]
    opened.close()


def test_a_photograph_keeps_its_place_when_another_of_its_name_comes(tmp_path):
    cv2.imwrite(str(tmp_path / "same.png"), BENT_UP.image)
    opened = PhotographFolder(tmp_path)
    measured(opened)
    cv2.imwrite(str(tmp_path / "same.bmp"), BENT_UP.image)
    opened.listing(0)
    assert list(measured(opened)) == ["same", "same.bmp"]
    opened.set_known("same", clicked(), for_all=True)
    assert [one["state"] for one in measured(opened).values()] == ["found", "found"]
    opened.close()


def test_a_correction_of_a_photograph_that_was_renamed_is_told(photographs):
    photographs.set_known("a", clicked(), for_all=False)
    measured(photographs)
    assert photographs.listing(0)["unused"] == ""
    (photographs.folder / "a.png").rename(photographs.folder / "c.png")
    said = photographs.listing(0)["unused"]
    assert "a.optics.json and a.sheet.toml belong to no image there and are not used" in said

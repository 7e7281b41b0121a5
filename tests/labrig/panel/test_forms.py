"""Files and forms, plans, calibrations: what a page asks for before and between runs."""

from __future__ import annotations

import json
import tomllib

import numpy as np
import pytest

from labrig.config import load_load_cell
from labrig.config.templates import template_text
from labrig.panel.core import configuration_files as files
from labrig.session.tables.drive_table import load_protocol
from labrig.vision import CalibrationBoard, Optics
from tests.labrig.panel.page import Page

pytestmark = pytest.mark.slow  # the panel's process, for few tests


@pytest.fixture
def page(server):
    """A page that holds control."""
    found = Page(server)
    found.take_control(force=True)
    yield found
    found.close()


def test_every_shipped_file_is_read_as_what_it_is_and_comes_back_the_same():
    for name in ("rig.toml", "sheet.toml", "protocol.toml", "load_cell.toml", "optics.json"):
        text, kind = template_text(name), name.split(".")[0]
        found = files.from_text(kind, text, name)
        assert files.kind_of(text, "." + name.split(".")[1]) == kind
        assert found.errors == []
        if kind != "optics":
            again = files.from_values(kind, json.loads(json.dumps(found.values)), name, text)
            assert again.text == text
            bare = files.from_values(kind, found.values, name)
            assert tomllib.loads(bare.text) == tomllib.loads(text)


def test_a_value_is_changed_and_the_comments_stay():
    text = template_text("protocol.toml")
    values = files.from_text("protocol", text, "protocol.toml").values
    values["pulse_train"]["pulse_s"] = 0.8
    values["places"] = [{"configuration": "long", "positions_mm": [5, 10]}]
    values["extras"] = None
    found = files.from_values("protocol", values, "protocol.toml", text)
    assert found.errors == []
    assert "# at 0 V, before the pulses" in found.text
    again = tomllib.loads(found.text)
    assert again["pulse_train"]["pulse_s"] == 0.8
    assert again["places"] == [{"configuration": "long", "positions_mm": [5, 10]}]
    assert "extras" not in again


@pytest.mark.parametrize(
    ("kind", "text", "told"),
    [
        ("protocol", "places = 3", "places"),
        ("protocol", "x = [", "not valid TOML"),
        ("sheet", "[long]\nfree_length_mm = -1", "free_length_mm"),
        ("optics", "{", "not valid JSON"),
        ("optics", "[]", "JSON object"),
        ("model", "labrig_model = 99", "model file"),
    ],
)
def test_faults_are_told_in_sentences(server, kind, text, told):
    status, answer = server.ask("POST", "/api/files/check", {"kind": kind, "text": text})
    assert (status, answer["ok"]) == (200, False)
    assert told in " ".join(answer["errors"])


def test_a_protocol_is_written_from_a_form_and_only_when_it_is_right(page, rig_folder):
    status, made = page.ask("GET", "/api/files/protocol.toml")
    assert (status, made["kind"], made["errors"]) == (200, "protocol", [])
    values = made["values"]
    values["places"] = [{"configuration": "long", "positions_mm": [7.5]}]
    path = "/api/files/mine.toml"
    assert page.ask("PUT", path, {"kind": "protocol", "values": values})[0] == 200
    written = load_protocol(rig_folder / "mine.toml")
    assert written.places[0].positions_mm == [7.5]
    values["places"] = []
    status, answer = page.ask("PUT", path, {"kind": "protocol", "values": values})
    assert (status, "places" in answer["error"]) == (400, True)
    assert load_protocol(rig_folder / "mine.toml") == written
    assert page.ask("PUT", path, {"kind": "sheet", "text": "[long]"})[0] == 400
    listed = {f["name"]: f["kind"] for f in page.ask("GET", "/api/files")[1]["files"]}
    assert listed["mine.toml"] == "protocol"
    assert listed["optics.json"] == "optics"
    actions = page.ask("GET", "/api/log")[1]["actions"]
    assert actions[-1]["what"] == "wrote mine.toml"
    assert actions[-1]["who"] == "Ann (127.0.0.1)"


def test_schemas_and_plan_are_there_for_the_form(server):
    schemas = server.ask("GET", "/api/schemas")[1]
    assert set(schemas) == {"rig", "sheet", "protocol", "load_cell", "about"}
    status, plan = server.ask("POST", "/api/plan", {"protocol": "short.toml"})
    assert status == 200
    run = plan["runs"][0]
    assert run["steps"][0] == [0.0, 0.0] or run["steps"][0][1] in (0.0, 2.0)
    assert run["steps"][-1][1] == 0.0
    assert [row[3] for row in run["readings"]].count("kept") == 6
    again = server.ask("POST", "/api/plan", {"protocol_text": template_text("protocol.toml")})[1]
    assert len(again["runs"]) == 14
    status, answer = server.ask("POST", "/api/plan", {"protocol_text": "places = []"})
    assert (status, list(answer)) == (400, ["error"])


def test_acting_without_control_is_refused(server):
    page = Page(server)
    for method, path, body in (
        ("PUT", "/api/files/x.toml", {"kind": "protocol", "text": ""}),
        ("POST", "/api/weighing", {"loads_mN": [0, 1, 2]}),
        ("POST", "/api/camera", {"do": "start"}),
        ("POST", "/api/camera/view", {}),
        ("POST", "/api/model", {"name": None}),
        ("POST", "/api/preflight", {}),
        ("POST", "/api/stop_after_pulse", None),
    ):
        assert page.ask(method, path, body)[0] == 403, path
    assert server.ask("POST", "/api/control", {"do": "take", "name": "x"})[0] == 403
    page.close()


def test_control_of_a_page_that_has_gone_can_be_taken(server):
    first, second = Page(server), Page(server)
    first.take_control("Ann", force=True)
    second.until(lambda m: m["type"] == "control" and m["holder"] is not None)
    first.close()
    second.until(lambda m: m["type"] == "control" and m["clients"] == 1)
    assert second.take_control("Bob")["name"] == "Bob (127.0.0.1)"
    second.do("/api/control", do="release")
    second.until(lambda m: m["type"] == "control" and m["holder"] is None)
    second.close()


def test_the_preflight_of_a_simulated_rig_is_shown(page):
    assert page.ended(page.do("/api/preflight", protocol="short.toml"))["code"] == 0
    found = page.until("preflight")
    assert found["ok"]
    assert {"output at 0 V", "camera rate"} <= {check["name"] for check in found["checks"]}


def test_the_load_cell_is_weighed_and_the_line_accepted(page, rig_folder):
    before = load_load_cell(rig_folder / "load_cell.toml")
    assert page.ask("POST", "/api/weighing/accept", {})[0] == 409
    assert page.ended(page.do("/api/weighing", loads_mN=[0, 20, 40, 0]))["code"] == 0
    found = page.until("weighing")
    assert found["finished"]
    assert [len(m["points"]) for m in page.of("weighing")] == [0, 1, 2, 3, 4, 4]
    assert max(abs(point["off_mN"]) for point in found["points"]) < 1.0
    answer = page.do("/api/weighing/accept")
    made = load_load_cell(rig_folder / "load_cell.toml")
    assert made.sensitivity_V_per_N == pytest.approx(found["fit"]["sensitivity_V_per_N"])
    assert made.sensitivity_V_per_N == pytest.approx(before.sensitivity_V_per_N, rel=0.05)
    assert load_load_cell(rig_folder / answer["kept"]) == before
    assert page.ask("POST", "/api/weighing/accept", {})[0] == 409


def test_camera_clamp_scale_and_arc_are_set_by_clicks(page, rig_folder):
    job = page.do("/api/camera", do="start")
    page.until(lambda _: bool(page.pictures))
    optics = Optics.from_json((rig_folder / "optics.json").read_text())
    mask = {"mask_px": [[[310, 40], [520, 40], [520, 60]]]}
    optics = Optics.from_json(json.dumps(json.loads(optics.to_json()) | mask))
    (rig_folder / "optics.json").write_text(optics.to_json())
    status, answer = page.ask("POST", "/api/camera/view", {"board": {"columns": 12, "rows": 9}})
    assert (status, "corners" in answer["error"]) == (400, True)  # the sheet is no board
    made = page.do(
        "/api/camera/calibrate",
        ruler_px=[[100, 100], [300, 100]],
        ruler_mm=200 / optics.px_per_mm,
        clamp_px=list(optics.clamp_px),
    )
    assert made["px_per_mm"] == pytest.approx(optics.px_per_mm)
    assert np.hypot(*np.subtract(made["axes_px"][1], made["axes_px"][0])) == pytest.approx(
        10 * optics.px_per_mm
    )
    at = [optics.clamp_px[0] + 40 * optics.px_per_mm, optics.clamp_px[1]]
    arc = page.do("/api/camera/arc", px=at)
    assert arc["radius_mm"] == pytest.approx(40.0)
    assert arc["origin_deg"] == pytest.approx(0.0)
    answer = page.do("/api/camera/accept")
    new = Optics.from_json((rig_folder / "optics.json").read_text())
    assert (new.method, new.mask_px) == ("ruler", optics.mask_px)
    assert answer["carried"].startswith("taken over from the one before: ")
    assert "mask_px" in answer["carried"]
    assert Optics.from_json((rig_folder / answer["kept"]).read_text()) == optics
    status, answer = page.ask(
        "POST", "/api/camera/refine", {"what": "corner", "px": [5, 5], "reach_px": 12}
    )
    assert (status, "edge" in answer["error"]) == (400, True)
    page.do("/api/camera", do="end")
    assert page.ended(job)["code"] == 0


def test_a_board_that_is_seen_calibrates_the_camera():
    from labrig.panel.calibration.camera_calibration import CameraCalibrationRun

    board = CalibrationBoard(12, 9, 5.0, 3.6)
    picture = np.pad(board.image(8), 40, constant_values=255)
    making = CameraCalibrationRun()
    view = making.add_view(picture, board)
    assert len(view["corners_px"]) == 11 * 8
    found = making.from_board(board, [view["view"]], (40.0, 40.0), None)
    assert found["px_per_mm"] == pytest.approx(8.0, rel=2e-3)
    assert found["residual_px"] < 0.1

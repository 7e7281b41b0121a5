"""The sessions of the data folder, as the page lists, opens, compares and exports them."""

from __future__ import annotations

import io
import zipfile

import pytest

from labrig.session import open_session, store_measurements
from tests.labrig.panel.page import Page
from tests.labrig.session.session_recording import record, small_schedule

pytestmark = pytest.mark.slow  # the panel's process, for few tests


@pytest.fixture(scope="module")
def library(server, rig_folder):
    """Two sessions, one below, and a damaged one."""
    (rig_folder / "july").mkdir()
    record(rig_folder / "a.h5", small_schedule(2))
    record(rig_folder / "july" / "b.h5", small_schedule(3))
    (rig_folder / "damaged.h5").write_bytes(b"nothing")
    return server


def get(server, path):
    """A request that must go well."""
    status, answer = server.ask("GET", path)
    assert status == 200, answer
    return answer


def test_sessions_are_listed_sorted_and_found(library):
    found = get(library, "/api/library?sort=readings")
    assert [one["name"] for one in found["sessions"]] == ["july/b.h5", "a.h5", "damaged.h5"]
    assert (found["total"], found["damaged"], found["pending"]) == (3, 1, 0)
    assert found["sessions"][2]["error"]
    assert [one["name"] for one in get(library, "/api/library?text=july")["sessions"]] == [
        "july/b.h5"
    ]
    part = get(library, "/api/library?sort=name&down=0&limit=1&offset=1")
    assert ([one["name"] for one in part["sessions"]], part["total"]) == (["damaged.h5"], 3)
    assert library.ask("GET", "/api/library?sort=colour")[0] == 400
    assert library.ask("GET", "/api/library?limit=1000000")[0] == 400


def test_one_session_shows_its_runs_and_its_log(library, rig_folder):
    found = get(library, "/api/library/session?name=july/b.h5")
    with open_session(rig_folder / "july" / "b.h5") as session:
        assert len(found["runs_table"]) == found["runs"] == len(session.runs)
        assert len(found["log"]) == len(session.events)
        assert found["readings"] == sum(len(run.readings) for run in session.runs)
    assert library.ask("GET", "/api/library/session?name=damaged.h5")[0] == 400
    assert library.ask("GET", "/api/library/session?name=gone.h5")[0] == 404


def test_two_sessions_are_compared_condition_by_condition(library):
    found = get(library, "/api/library/compare?a=a.h5&b=july/b.h5")
    assert (found["a"]["name"], found["b"]["name"]) == ("a.h5", "july/b.h5")
    assert len(found["rows"]) == 3 * 3  # three places, three voltages
    by_count = {(row["a"]["readings"], row["b"]["readings"]) for row in found["rows"]}
    assert by_count == {(2, 2), (2, 3)}
    same = get(library, "/api/library/compare?a=a.h5&b=a.h5")["rows"]
    assert all(row["a"] == row["b"] for row in same)


def test_a_session_is_exported_as_it_is_and_its_tables_once_it_is_analysed(library, rig_folder):
    whole = get(library, "/api/library/export?name=a.h5&as=h5")
    assert whole == (rig_folder / "a.h5").read_bytes()
    status, answer = library.ask("GET", "/api/library/export?name=a.h5&as=csv")
    assert (status, "labrig analyze" in answer["error"]) == (400, True)
    assert library.ask("GET", "/api/library/export?name=a.h5&as=exe")[0] == 400
    assert library.ask("GET", "/api/library/export?name=../a.h5")[0] == 400


def test_the_tables_of_an_analysed_session_come_as_a_zip(library, rig_folder):
    from tests.labrig.session.measured import measurements

    record(rig_folder / "analysed.h5", small_schedule(2))
    store_measurements(rig_folder / "analysed.h5", measurements())
    packed = get(library, "/api/library/export?name=analysed.h5&as=csv")
    names = zipfile.ZipFile(io.BytesIO(packed)).namelist()
    assert "analysed/forces.csv" in names


def test_who_holds_control_marks_a_reading_of_a_closed_session_and_takes_it_back(
    library, rig_folder
):
    record(rig_folder / "marked.h5", small_schedule(2))
    page = Page(library)
    body = {"name": "marked.h5", "run": 0, "reading": 1, "why": "a bubble"}
    assert page.ask("POST", "/api/library/mark", body)[0] == 403
    page.take_control()
    status, answer = page.ask("POST", "/api/library/mark", body)
    assert (status, answer) == (200, {"ok": True})
    found = get(library, "/api/library/session?name=marked.h5")
    assert (found["invalid"], found["marks"], found["runs_table"][0]["invalid"]) == (1, 1, 1)
    (mark,) = found["marks_table"]
    assert (mark["run"], mark["reading"], mark["why"], mark["invalid"]) == (1, 2, "a bubble", True)
    assert page.ask("POST", "/api/library/mark", body)[0] == 400  # it is marked already
    undo = body | {"why": "none", "undo": True}
    assert page.ask("POST", "/api/library/mark", undo)[0] == 200
    assert get(library, "/api/library/session?name=marked.h5")["invalid"] == 0
    assert page.ask("POST", "/api/library/mark", body | {"run": 99})[0] == 400
    page.close()
    actions = get(library, "/api/log")["actions"]
    assert any("marked reading 2 of run 1 invalid in marked.h5" in one["what"] for one in actions)


def test_a_watcher_may_look_and_export(library):
    page = Page(library)
    assert page.ask("GET", "/api/library")[0] == 200
    page.close()

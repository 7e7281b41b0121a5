"""The result of a session, as the panel answers for the page."""

from __future__ import annotations

import http.client
import os
import threading
import time
from contextlib import suppress
from dataclasses import replace

import pytest

from labrig.model_file import save_model
from labrig.session import Mark, add_mark, load_measurements, open_session, store_measurements
from model import fit
from tests.labrig.panel.page import Server
from tests.labrig.report_data import POSITIONS_M, measure, session

pytestmark = pytest.mark.slow  # the panel's process, and fits in another


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """One session that is analysed, one that is not, and a damaged one."""
    made = tmp_path_factory.mktemp("results")
    session(made / "a.h5", measure("long"))
    session(made / "bare.h5", None)
    (made / "damaged.h5").write_bytes(b"nothing")
    return made


@pytest.fixture(scope="module")
def server(folder):
    found = Server(None, "--data", str(folder))
    yield found
    found.end()


def get(server, path, status=200):
    found, answer = server.ask("GET", f"/api/result{path}")
    assert found == status, answer
    return answer


def conditions(result):
    return [one for part in result["configurations"] for one in part["conditions"]]


def test_what_was_measured_comes_first_then_the_models_then_how_b_and_eibm_settled(server, folder):
    first = get(server, "?session=a.h5&upto=measured")
    assert (first["complete"], first["models"]) == (False, [])
    assert len(conditions(first)) == len(load_measurements(folder / "a.h5").conditions)
    whole = get(server, "?session=a.h5")
    assert whole["complete"]
    assert [one["id"] for one in whole["models"]] == ["constant", "along"]
    assert [one["kind"] for one in whole["missing"]] == ["fit", "diagnose", "report"]
    assert [one["curve"] for one in conditions(whole)] == [
        one["curve"] for one in conditions(first)
    ]
    assert get(server, "?session=a.h5&upto=measured") == whole  # now it is kept


@pytest.mark.thorough
def test_a_result_is_kept_until_one_of_its_files_changes(server, folder):
    whole = get(server, "?session=a.h5")
    kept = next((folder / ".labrig" / "results").glob("a-*.json"))
    state, text = kept.read_text().split("\n", 1)
    kept.write_text(f"{state}\n{text.replace('constant EIBM', 'kept')}")
    other = Server(None, "--data", str(folder))
    try:
        assert get(other, "?session=a.h5&upto=measured")["models"][0]["name"] == "kept"
        os.utime(folder / "a.h5")
        assert get(other, "?session=a.h5&upto=measured")["models"] == []
        assert get(other, "?session=a.h5") == whole
    finally:
        other.end()


@pytest.mark.thorough
def test_the_panel_ends_at_once_while_a_result_is_computed(folder):
    other = Server(None, "--data", str(folder))
    session(folder / "slow.h5", measure())
    asking = threading.Thread(target=lambda: _ignored(other, "?session=slow.h5"))
    asking.start()
    asking.join(1.0)  # it takes longer
    assert asking.is_alive()
    before_s = time.monotonic()
    other.end()
    assert time.monotonic() - before_s < 10.0
    asking.join(10.0)
    (folder / "slow.h5").unlink()


def _ignored(server, path):
    with suppress(OSError, http.client.HTTPException):
        server.ask("GET", f"/api/result{path}")


@pytest.mark.thorough
def test_a_model_file_of_other_data_is_out_of_date(server, folder):
    files = {"Fit": folder / "a.model.toml", "Diagnose": folder / "a.model+.toml"}
    for file in files.values():
        save_model(fit(measure("long", seed=2)).model, file)
    assert get(server, "?session=a.h5")["out_of_date"] == []
    for file in files.values():
        file.write_text(file.read_text().replace("abab", "cdcd"))
    told = get(server, "?session=a.h5")["out_of_date"]
    for (job, file), text in zip(files.items(), told, strict=True):
        assert text.startswith(f"{file.name} was fitted to other data")
        assert text.endswith(f"{job} writes it again.")
        file.unlink()


def test_a_mark_after_the_end_makes_what_the_page_shows_out_of_date(server, folder):
    path = session(folder / "marked.h5", measure("long"))
    store_measurements(path, replace(measure("long"), checksum=checksum_of(path)))
    report = folder / "marked.report.html"
    report.write_text(f'<meta name="labrig-session-state" content="{checksum_of(path, "state")}">')
    assert get(server, "?session=marked.h5&upto=fitted")["out_of_date"] == []
    add_mark(path, Mark(run=0, reading=1, why="a bubble", who="A. P."))
    for upto in ("measured", "fitted"):
        found = get(server, f"?session=marked.h5&upto={upto}")
        assert "were marked after the analysis" in found["out_of_date"][0], upto
        assert "marked.report.html" in found["out_of_date"][1]
        assert found["warnings"] == []
    add_mark(path, Mark(run=0, reading=1, why="no", who="A. P.", invalid=False))
    (left,) = get(server, "?session=marked.h5&upto=measured")["out_of_date"]
    assert left.startswith("marked.report.html")  # which does not tell of the marks


def checksum_of(path, what="data"):
    with open_session(path) as opened:
        return getattr(opened, f"{what}_checksum")


def test_a_session_that_is_not_analysed_shows_its_forces_and_what_to_press(server):
    found = get(server, "?session=bare.h5&upto=measured")
    assert found["missing"][0]["kind"] == "analyze"
    assert all(one["force"] and one["curve"] is None for one in conditions(found))


def test_what_is_no_session_is_refused_in_a_sentence(server):
    assert "is not an HDF5 file" in get(server, "?session=damaged.h5", 400)["error"]
    get(server, "?session=gone.h5", 404)
    get(server, "?session=../a.h5", 400)
    get(server, "/reading?session=a.h5&condition=500&index=0", 400)
    assert get(server, "/reading?session=a.h5&condition=0&index=0") == {"curve": None}


@pytest.mark.thorough
def test_steps_of_b_and_eibm_are_shown_as_they_become_known(server, folder):
    session(folder / "steps.h5", measure("long"))
    known = [get(server, "/settling?session=steps.h5")]
    while not known[-1]["complete"]:
        known.append(get(server, "/settling?session=steps.h5"))
    counts = [len(one["convergence"]["long"]) for one in known]
    assert counts == sorted(counts)
    assert counts[-1] == len(POSITIONS_M)
    whole = get(server, "?session=steps.h5&upto=measured")  # kept, now that it is complete
    assert whole["convergence"] == known[-1]["convergence"]


def test_there_is_one_way_to_the_report_and_it_may_run_no_scripts(server, folder):
    get(server, "/report?session=a.h5", 404)
    (folder / "a.report.html").write_text("<script>alert(1)</script><h1>Report</h1>")
    status, answer = server.ask("GET", "/api/analysis/output?session=a.h5&name=report")
    assert status == 200
    assert b"<h1>Report</h1>" in answer
    assert "report" not in [one["kind"] for one in get(server, "?session=a.h5")["missing"]]
    (folder / "a.report.html").unlink()

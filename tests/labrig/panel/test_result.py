"""The result of a session, as the panel answers for the page."""

from __future__ import annotations

import http.client
import os
import threading
import time
from contextlib import suppress

import pytest

from labrig.model_file import save_model
from labrig.session import load_measurements
from model import fit
from tests.labrig.panel.page import Server
from tests.labrig.report_data import measure, session

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


def test_a_model_file_of_other_data_is_out_of_date(server, folder):
    file = folder / "a.model.toml"
    save_model(fit(measure("long", seed=2)).model, file)
    assert get(server, "?session=a.h5")["out_of_date"] == []
    file.write_text(file.read_text().replace("abab", "cdcd"))
    assert "a.model.toml was fitted to other data" in get(server, "?session=a.h5")["out_of_date"][0]
    file.unlink()


def test_a_session_that_is_not_analysed_shows_its_forces_and_what_to_press(server):
    found = get(server, "?session=bare.h5&upto=measured")
    assert found["missing"][0]["kind"] == "analyze"
    assert all(one["force"] and one["curve"] is None for one in conditions(found))


def test_what_is_no_session_is_refused_in_a_sentence(server):
    assert "is no HDF5 file" in get(server, "?session=damaged.h5", 400)["error"]
    get(server, "?session=gone.h5", 404)
    get(server, "?session=../a.h5", 400)
    get(server, "/reading?session=a.h5&condition=500&index=0", 400)
    assert get(server, "/reading?session=a.h5&condition=0&index=0") == {"curve": None}


def test_the_report_may_run_no_scripts_of_its_own(server, folder):
    assert "press Report" in get(server, "/report?session=a.h5", 404)["error"]
    (folder / "a.report.html").write_text("<script>alert(1)</script><h1>Report</h1>")
    answer = get(server, "/report?session=a.h5")
    assert b"<h1>Report</h1>" in answer
    assert "report" not in [one["kind"] for one in get(server, "?session=a.h5")["missing"]]
    (folder / "a.report.html").unlink()

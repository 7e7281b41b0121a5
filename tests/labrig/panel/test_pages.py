"""The pages of the panel: each a plug-in, ours and those of other distributions."""

from __future__ import annotations

import http.client
import sys
import time
from pathlib import Path

import pytest

from drivers.plugins import PluginWarning
from labrig.panel.pages.conformance import content_faults, faults
from labrig.panel.pages.interface import PAGES, PanelPage, left_out, listing
from tests.cases import few
from tests.labrig.panel.page import Page
from tests.labrig.panel.plugin_pages import install, panel_with_plugins

TWICE = """
from labrig.panel.pages.interface import PanelPage
PAGE = PanelPage(title="Another one", order=0, data=lambda panel: {})
SESSIONS = PanelPage(title="sessions", order=0, data=lambda panel: {})
"""


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """A panel of sessions, where another distribution has pages."""
    with panel_with_plugins(tmp_path_factory.mktemp("site")) as server:
        yield server


@pytest.mark.parametrize("name", PAGES.parts())
def test_each_of_our_pages_keeps_the_contract(name):
    assert faults(PAGES.get(name)) == []


def test_each_fault_of_a_page_is_named():
    class Odd:
        title, order, modes, opens, script, data, router = "", "1", {"rig"}, None, "x.js", 1, 2

    assert len(faults(Odd())) == 7
    assert "neither a script nor data" in " ".join(faults("no page"))


GOOD = {"title": "T", "columns": ["a", "b"], "rows": [[1, "x"], (2.5, None)]}


@pytest.mark.parametrize(
    "data", [{}, {"sentences": ["All is well."]}, {"tables": (GOOD, {"rows": [[1]]})}]
)
def test_what_a_page_can_show_has_no_fault(data):
    assert content_faults(data) == []


@pytest.mark.parametrize(
    ("data", "says"),
    few(
        [
            ([1], "data returned a list, not a dict with 'sentences' and 'tables'"),
            ({"tables": {**GOOD}}, "tables is a dict, not a list"),
            (
                {"tables": [{"title": "x", "cols": ["a"], "rows": [[1]]}]},
                "tables[0] has 'cols', which is none of title, columns, rows",
            ),
            ({"sentences": "All is well."}, "sentences is a str, not a list"),
            ({"sentences": [1]}, "sentences[0] is an int, not a text"),
            ({"text": []}, "data has 'text', which is none of sentences, tables"),
            ({"tables": ["x"]}, "tables[0] is a str, not a dict"),
            ({"tables": [{**GOOD, "title": 1}]}, "tables[0].title is an int, not a text"),
            ({"tables": [{**GOOD, "columns": [1, "b"]}]}, "tables[0].columns[0] is an int, not a"),
            ({"tables": [{**GOOD, "rows": 3}]}, "tables[0].rows is an int, not a list"),
            ({"tables": [{**GOOD, "rows": [3]}]}, "tables[0].rows[0] is an int, not a list"),
            ({"tables": [{**GOOD, "rows": [[1]]}]}, "tables[0].rows[0] has 1 cell, not 2"),
            (
                {"tables": [{**GOOD, "rows": [[1, float("nan")]]}]},
                "tables[0].rows[0][1] is nan: JSON has no such number; use None",
            ),
            (
                {"tables": [{**GOOD, "rows": [[1, object()]]}]},
                "tables[0].rows[0][1] is an object, not a text, a number, True, False or None",
            ),
        ]
    ),
)
def test_what_a_page_cannot_show_is_one_sentence(data, says):
    (found,) = content_faults(data)
    assert found.startswith(says)


def test_the_menu_is_that_of_the_mode_and_the_other_pages_are_reached_by_links():
    def menu(mode):
        return [page["name"] for page in listing(mode)["pages"] if page["menu"]]

    assert {"run", "load-cell", "library"} <= set(menu("rig"))
    assert "run" not in menu("sessions")
    assert "session" not in menu("rig")
    assert [listing(mode)["first"] for mode in ("rig", "sessions", "replay")] == [
        "run", "library", "replay",
    ]  # fmt: skip


def test_every_listed_script_is_in_the_package():
    static = Path(sys.modules["labrig.panel"].__path__[0]) / "static"
    for page in listing("rig")["pages"]:
        assert (static / page["script"].removeprefix("/static/")).is_file()


def test_a_faulty_page_of_another_distribution_is_left_out(tmp_path, monkeypatch):
    install(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    try:
        with pytest.warns(PluginWarning, match=r"page of the panel 'bad'.*missing\.js"):
            known = PAGES.parts()
        assert isinstance(known["notes"].part, PanelPage)
        assert "bad" not in known
        assert PAGES.origins()["plain_notes"] == "labrig-notes 0.3"
    finally:
        sys.modules.pop("labrig_notes", None)


def test_a_page_cannot_take_what_another_has_nor_an_address_that_is_none(tmp_path, monkeypatch):
    (tmp_path / "labrig_twice.py").write_text(TWICE)
    info = tmp_path / "labrig_twice-1.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: labrig-twice\nVersion: 1\n")
    points = "load-cell = labrig_twice:PAGE\na/b = labrig_twice:PAGE\n"
    points += "mine = labrig_twice:SESSIONS\n"
    (info / "entry_points.txt").write_text("[labrig.page_panels]\n" + points)
    monkeypatch.syspath_prepend(tmp_path)
    try:
        titles = {page["name"]: page["title"] for page in listing("rig")["pages"]}
        assert titles["load-cell"] == "Load cell"
        assert not {"a/b", "mine"} & set(titles)
        assert [sentence.split("'")[1] for sentence in left_out()] == ["a/b", "load-cell", "mine"]
        assert left_out()[-1] == (
            "the page of the panel 'mine' of labrig-twice is left out: there is a page with the "
            "title 'Sessions' already ('library' of labrig)."
        )
    finally:
        sys.modules.pop("labrig_twice", None)


@pytest.mark.slow
def test_pages_of_another_distribution_are_listed_among_ours(installed):
    found = installed.ask("GET", "/api/status")[1]["pages"]
    own = {page["name"]: page for page in found}
    assert own["notes"]["script"] == "/plugins/notes/page.js"
    assert own["plain-notes"]["script"] == "/static/js/data_page.js"
    names = [page["name"] for page in found]
    assert names.index("new") < names.index("notes") < names.index("load-cell")
    assert Page(installed).hello["status"]["pages"] == found


@pytest.mark.slow
def test_their_files_need_the_token_and_have_the_headers_of_all_others(installed):
    assert installed.ask("GET", "/plugins/notes/page.js", as_browser=False)[0] == 401
    connection = http.client.HTTPConnection(installed.netloc, timeout=20)
    for path in ("/plugins/notes/page.js", "/static/js/main.js"):
        connection.request("GET", path, headers={"Cookie": f"labrig_token={installed.token}"})
        answer = connection.getresponse()
        answer.read()
        assert answer.status == 200
        assert "javascript" in answer.headers["Content-Type"]
        assert answer.headers["X-Content-Type-Options"] == "nosniff"
        assert "script-src 'self'" in answer.headers["Content-Security-Policy"]
    connection.close()


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [
        "notes/secret.toml", "notes/../labrig_notes.py", "notes/%2e%2e/labrig_notes.py",
        "notes/..%2flabrig_notes.py", "notes//etc/passwd", "notes/", "notes/page.js%00",
        "plain-notes/page.js", "nobody/page.js", "run/run.js",
    ],
)  # fmt: skip
def test_nothing_but_a_pages_own_files_is_served(installed, path):
    status, answer = installed.ask("GET", f"/plugins/{path}")
    assert status == 404
    assert set(answer) == {"error"}


@pytest.mark.slow
def test_their_data_and_routes_stand_below_their_name(installed):
    status, data = installed.ask("GET", "/api/pages/notes")
    assert (status, data["sentences"]) == (200, ["All is noted."])
    assert installed.ask("GET", "/api/pages/notes", as_browser=False)[0] == 401
    page = Page(installed)
    assert page.ask("POST", "/api/pages/notes/note")[0] == 403
    page.take_control("Ann")
    assert page.do("/api/pages/notes/note")["who"].startswith("Ann")
    actions = installed.ask("GET", "/api/log")[1]["actions"]
    assert actions[-1]["what"] == "wrote a note"
    page.close()


@pytest.mark.slow
def test_a_page_that_fails_answers_with_a_sentence(installed):
    assert installed.ask("GET", "/api/pages/notes/refused") == (
        400, {"error": "there are no notes."}
    )  # fmt: skip
    status, answer = installed.ask("GET", "/api/pages/failing")
    assert status == 500
    assert answer["error"] == "the page 'failing' of labrig-notes 0.3 has no data: KeyError: 'ink'."
    status, answer = installed.ask("GET", "/api/pages/leaving")
    assert status == 500
    assert answer["error"].endswith("'leaving' of labrig-notes 0.3 has no data: SystemExit: 1.")


@pytest.mark.slow
def test_data_that_a_page_cannot_show_is_a_sentence_with_the_page_and_its_distribution(installed):
    assert installed.ask("GET", "/api/pages/odd") == (
        500,
        {
            "error": "the page 'odd' of labrig-notes 0.3 has nothing to show: data returned a "
            "list, not a dict with 'sentences' and 'tables'."
        },
    )
    status, answer = installed.ask("GET", "/api/pages/holes")  # a page with a script of its own
    assert status == 500
    assert answer["error"].startswith(
        "the page 'holes' of labrig-notes 0.3 has nothing to show: "
        "data.rooms[0].humidity[1] is nan: JSON has no such number"
    )


@pytest.mark.slow
def test_the_log_of_the_panel_names_every_part_that_is_left_out_and_why(installed):
    status, body = installed.ask("GET", "/api/log")
    assert status == 200
    said = [one["what"] for one in body["actions"] if one["who"] == "labrig"]
    (bad,) = (text for text in said if "'bad'" in text)
    assert bad.startswith(
        "the page of the panel 'bad' of labrig-notes (labrig_notes:BAD) is left out: "
    )
    assert len(said) == len(set(said))


@pytest.mark.slow
def test_a_page_that_does_not_answer_keeps_neither_stop_nor_other_pages_waiting(installed):
    waiting = [http.client.HTTPConnection(installed.netloc, timeout=20) for _ in range(50)]
    try:
        for each in waiting:
            own = {"Cookie": f"labrig_token={installed.token}"}
            each.request("GET", "/api/pages/slow", headers=own)
        time.sleep(1)  # noqa: TID251 - until a server on the real clock has all of them
        began_s = time.monotonic()
        assert installed.ask("POST", "/api/stop", {"why": "a test"})[0] == 200
        assert installed.ask("GET", "/api/pages/notes")[0] == 200
        assert installed.ask("GET", "/api/status")[0] == 200
        assert time.monotonic() - began_s < 5
    finally:
        for each in waiting:
            each.close()

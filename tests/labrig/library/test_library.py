"""A folder of sessions, looked through once."""

from __future__ import annotations

import json
import os
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.library import CatalogueEntry, Library, SessionQuery, index, read_entry
from labrig.library.database import Database
from labrig.library.records import put_entry
from labrig.library.select import select
from labrig.model_file import load_model, save_model
from labrig.session import open_session
from tests.cases import few
from tests.labrig.session.session_recording import record, small_schedule
from tests.processes import last_words


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """A small session of three runs."""
    path = tmp_path_factory.mktemp("recorded") / "one.h5"
    record(path, small_schedule())
    return path


@pytest.fixture
def folder(session, tmp_path):
    """Three sessions, one of them below, and a file that is none."""
    (tmp_path / "below").mkdir()
    for name in ("a.h5", "b.h5", "below/c.h5"):
        shutil.copy(session, tmp_path / name)
    (tmp_path / "broken.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + b"\x00" * 100)
    return tmp_path


@pytest.fixture
def looked(monkeypatch):
    """Names of the files that were opened."""
    names = []

    def look(path, name):
        names.append(name)
        return read_entry(path, name)

    monkeypatch.setattr(index, "read_entry", look)
    return names


def test_an_entry_of_imported_tables_says_what_they_hold(tmp_path):
    tables = Path(__file__).parents[3] / "docs" / "tutorials" / "data"
    files = [f"--{name}={tables / name}.csv" for name in ("forces", "curves")]
    path = tmp_path / "mine.h5"
    sheet = f"--sheet={tables / 'sheet.toml'}"
    assert run(["import", sheet, *files, "-o", str(path), "--yes"]) == 0
    entry = read_entry(path, "mine.h5")
    assert (entry.sheet, entry.readings, entry.invalid) == (("long",), 24, 0)
    assert entry.largest_force_mN == pytest.approx(1.957, abs=1e-3)


@pytest.mark.slow
def test_an_entry_says_what_the_session_says(session):
    entry = read_entry(session, "one.h5")
    changes = []
    with open_session(session) as opened:
        assert entry.started == opened.started
        assert entry.checksum == opened.checksum
        assert entry.outcome == opened.outcome.value
        assert entry.output == opened.output_state.value
        assert entry.readings == sum(len(run.readings) for run in opened.runs)
        for run in opened.runs:  # each at a place of its own
            rows = run.readings[run.readings["kind"] != "discarded"]
            force = {v: 1e3 * rows["force_N"][rows["voltage_V"] == v].mean() for v in (0, 2, -2)}
            changes += [abs(force[v] - force[0]) for v in (2, -2)]
    assert entry.largest_force_mN == pytest.approx(max(changes))
    assert entry.sheet == ("long", "short")
    assert (entry.runs, entry.runs_complete) == (3, 3)


@pytest.mark.slow
def test_a_file_is_opened_once_and_again_only_when_it_has_changed(folder, looked):
    assert Library(folder).refresh() == 0
    assert sorted(looked) == ["a.h5", "b.h5", "below/c.h5", "broken.h5"]
    looked.clear()
    again = Library(folder)
    again.refresh()
    assert looked == []
    assert len(again.entries()) == 4
    os.utime(folder / "b.h5", (1, 1))
    (folder / "a.h5").unlink()
    again.refresh()
    assert looked == ["b.h5"]
    assert sorted(entry.name for entry in again.entries()) == ["b.h5", "below/c.h5", "broken.h5"]


def test_every_name_that_a_session_may_have_is_listed(tmp_path):
    for name in ("a.h5", "b.hdf5", "c.nxs", "D.H5", "e.csv"):
        (tmp_path / name).write_bytes(b"no session")
    library = Library(tmp_path)
    library.refresh()
    assert sorted(entry.name for entry in library.entries()) == ["D.H5", "a.h5", "b.hdf5", "c.nxs"]


@pytest.mark.slow
def test_a_damaged_file_is_listed_with_its_fault(folder):
    library = Library(folder)
    library.refresh()
    broken = next(entry for entry in library.entries() if entry.name == "broken.h5")
    assert broken.error
    assert str(folder) not in broken.error


@pytest.mark.slow
@pytest.mark.parametrize("damage", few(["empty", "text", "zeros", "half", "no_table", "no_entry"]))
def test_a_cache_that_is_damaged_is_made_anew(folder, looked, damage):
    library = Library(folder)
    library.refresh()
    path = library.cache
    library.close()
    whole = path.read_bytes()
    if damage in {"no_table", "no_entry"}:
        with closing(sqlite3.connect(path)) as file, file:
            file.execute(
                "DROP TABLE texts" if damage == "no_table" else "UPDATE entries SET entry='{'"
            )
    else:
        path.write_bytes(
            {
                "empty": b"",
                "text": b"no database" * 500,
                "zeros": whole[:4096] + b"\0" * (len(whole) - 4096),
                "half": whole[: len(whole) // 2],
            }[damage]
        )
    again = Library(folder)
    again.refresh()
    found = again.find(SessionQuery(sort="name", down=False, text="h5"))
    assert [entry.name for entry in found.entries] == ["a.h5", "b.h5", "below/c.h5", "broken.h5"]
    looked.clear()
    again.refresh()
    assert looked == []
    assert again.cache == path


@pytest.mark.slow
def test_nothing_is_written_to_the_folder_of_the_sessions(folder):
    before = sorted(folder.rglob("*"))
    library = Library(folder)
    library.refresh()
    assert sorted(folder.rglob("*")) == before
    assert folder not in library.cache.parents


@pytest.mark.slow
def test_a_cache_that_cannot_be_written_is_kept_in_memory(folder, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("LABRIG_CACHE", str(tmp_path / "file"))
    library = Library(folder)
    library.refresh()
    assert library.cache is None
    assert len(library.entries()) == 4


@pytest.mark.thorough
@pytest.mark.slow
def test_programs_that_look_at_once_do_not_disturb_each_other(folder):
    script = (
        "import sys; from pathlib import Path; from labrig.library import Library\n"
        "library = Library(Path(sys.argv[1])); library.refresh()\n"
        "assert library.cache is not None\n"
        "print(*[entry.name for entry in library.entries()])"
    )
    command = [sys.executable, "-c", script, str(folder)]
    several = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    said = {last_words(process)[0].strip() for process in several}
    assert [process.returncode for process in several] == [0] * 2
    assert said == {"a.h5 b.h5 below/c.h5 broken.h5"}


@pytest.mark.slow
def test_a_folder_with_more_files_than_are_listed_says_so(folder, monkeypatch, capsys):
    from labrig.cli.main import run

    monkeypatch.setattr(index, "MOST_FILES", 2)
    library = Library(folder)
    library.refresh()
    assert "only the first 2" in library.cut
    assert len(library.entries()) == 2
    assert run(["list", str(folder)]) == 0
    assert "only the first 2" in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_says_what_it_does_not_show(folder, capsys):
    from labrig.cli.main import run

    assert (
        run(["list", str(folder), "--sort", "name", "--up", "--limit", "2", "--offset", "1"]) == 0
    )
    said = capsys.readouterr().out
    assert "These are 2 to 3 of 4" in said
    assert "below/c.h5" in said
    assert "a.h5" not in said


@pytest.mark.slow
def test_the_command_says_why_its_table_is_empty(folder, tmp_path, capsys):
    from labrig.cli.main import run

    for asked, told in (
        ([str(tmp_path / "none")], "There is no session in this folder"),
        ([str(folder), "--text", "nobody"], "No session fits --text, --outcome and --sheet."),
        ([str(folder), "--outcome", "failed"], "No session fits --text, --outcome and --sheet."),
        ([str(folder), "--offset", "9"], "There are 4 in all; --offset leaves them out."),
    ):
        (tmp_path / "none").mkdir(exist_ok=True)
        assert run(["list", *asked]) == 0
        assert told in capsys.readouterr().out


@pytest.mark.slow
def test_a_scan_that_has_no_time_says_how_many_files_are_left(folder):
    library = Library(folder)
    left = library.refresh(budget_s=0.0)
    assert left > 0
    while left:
        fewer = library.refresh(budget_s=0.02)
        assert fewer < left or fewer == 0
        left = fewer
    assert len(library.entries()) == 4


@pytest.mark.slow
def test_links_to_other_folders_are_not_followed(folder, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    shutil.copy(folder / "a.h5", elsewhere / "d.h5")
    (folder / "way").symlink_to(elsewhere)
    (folder / "e.h5").symlink_to(elsewhere / "d.h5")
    library = Library(folder)
    library.refresh()
    assert not {"way/d.h5", "e.h5"} & {entry.name for entry in library.entries()}


@pytest.mark.slow
def test_the_newest_model_of_a_session_is_shown_with_it(folder, model_file):
    with open_session(folder / "a.h5") as opened:
        checksum = opened.checksum
    model = load_model(model_file)
    for name, when, sha256 in (("m1", 10, checksum), ("m2", 20, checksum), ("m3", 30, "0" * 64)):
        path = folder / f"{name}.toml"
        scaled = {k: replace(s, B=s.B.scaled(when, "N m^2")) for k, s in model.sheets.items()}
        save_model(replace(model, checksum=sha256, sheets=scaled), path)
        os.utime(path, (when, when))
    library = Library(folder)
    library.refresh()
    entry = next(entry for entry in library.entries() if entry.name == "a.h5")
    first = next(iter(model.sheets.values()))
    assert entry.fitted("B_Nm2") == pytest.approx(20 * first.B.value)
    moments = [abs(first.mean_eibm(v)) for v in first.eibm]
    assert entry.fitted("EIBM_Nm") == pytest.approx(max(moments))
    again = Library(folder)
    again.refresh()
    assert json.dumps([e.as_dict() for e in again.entries()]) == json.dumps(
        [e.as_dict() for e in library.entries()]
    )


@pytest.mark.slow
def test_a_model_beside_the_session_is_shown_rather_than_a_newer_copy_elsewhere(folder, model_file):
    with open_session(folder / "a.h5") as opened:
        model = replace(load_model(model_file), checksum=opened.checksum)
    (folder / "copy").mkdir()
    for when, name in enumerate(("copy/a.toml", "z.toml", "copy/model.toml"), 1):
        save_model(model, folder / name)
        os.utime(folder / name, (when, when))
        library = Library(folder)
        library.refresh()
        (fit,) = (e.fit for e in library.entries() if e.name == "a.h5")
        assert fit["long"]["model"] == ("copy/a.toml" if when == 1 else "z.toml")
    (below,) = (e.fit for e in library.entries() if e.name == "below/c.h5")  # of the same data
    assert below["long"]["model"] == "copy/model.toml"


@pytest.fixture
def model_file(tmp_path):
    """A model as `labrig fit` writes it."""
    import numpy as np

    from model import Along, ConfiguredSheet, Parameter, SheetGeometry, SheetModel

    sheet = SheetGeometry(
        configuration="long",
        free_length_m=0.05,
        width_m=0.011,
        thickness_m=2.1e-4,
        elongation_m=0.0,
        arc_radius_m=0.04,
        arc_origin_rad=0.0,
        initial_curvature=None,
    )
    rest = Along(np.array([0.0]), np.array([10.0]), np.array([0.1]), "1/m")
    eibm = {
        v: Along.constant(Parameter(value=m, sigma=1e-7, unit="N m"))
        for v, m in ((2.0, 9e-6), (-2.0, -8e-6))
    }
    one = ConfiguredSheet(sheet, Parameter(value=5e-7, sigma=1e-9, unit="N m^2"), rest, eibm)
    (tmp_path / "elsewhere").mkdir()
    path = tmp_path / "elsewhere" / ".made.toml"
    save_model(SheetModel(sheets={"long": one}), path)
    return path


ENTRIES = [
    CatalogueEntry(
        name="a.h5", started="2026-01-01", outcome="completed", sheet=("long",), scatter_mN=2.0
    ),
    CatalogueEntry(
        name="b.h5", started="2026-01-03", outcome="aborted", sheet=("short",), reason="STOP"
    ),
    CatalogueEntry(
        name="c.h5", started="2026-01-02", outcome="completed", sheet=("long",), scatter_mN=1.0
    ),
    CatalogueEntry(name="d.h5", error="is truncated."),
]


@pytest.mark.parametrize(
    ("asked", "wanted"),
    [
        ({}, "bcad"),
        ({"down": False}, "acbd"),
        ({"sort": "scatter_mN"}, "acbd"),
        ({"sort": "scatter_mN", "down": False}, "cabd"),
        ({"sort": "name", "down": False}, "abcd"),
        ({"outcome": "completed"}, "ca"),
        ({"sheet": "short"}, "b"),
        ({"text": "stop"}, "b"),
        ({"text": "TRUNCATED"}, "d"),
        ({"text": "long pulse"}, ""),
    ],
)
def test_entries_are_filtered_and_sorted(asked, wanted, tmp_path):
    assert "".join(entry.name[0] for entry in selected(tmp_path, ENTRIES, **asked)) == wanted


def selected(folder, entries, **asked):
    database = Database(folder)
    database.write(lambda connection: [put_entry(connection, entry) for entry in entries])
    return database.read(lambda connection: select(connection, SessionQuery(**asked))).entries


@pytest.mark.parametrize("down", [True, False])
def test_pages_are_parts_of_the_whole(tmp_path, down):
    asked = {"sort": "scatter_mN", "down": down}
    whole = selected(tmp_path, ENTRIES, **asked)
    assert len(whole) == 4
    for limit in (1, 2, 3, 4, 5):
        for offset in range(6):
            page = selected(tmp_path, [], **asked, limit=limit, offset=offset)
            assert page == whole[offset : offset + limit]


def test_an_entry_comes_back_as_it_was(session, tmp_path):
    entry = read_entry(session, "one.h5")
    assert selected(tmp_path, [entry]) == (entry,)


def test_an_unknown_column_is_named_with_those_that_are_known():
    with pytest.raises(BadInputError, match="started, name and B_Nm2"):
        SessionQuery(sort="colour")


@pytest.mark.slow
def test_the_command_lists_and_says_what_cannot_be_read(folder, capsys):
    from labrig.cli.main import run

    assert run(["list", str(folder), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert len(told["sessions"]) == 4
    assert run(["list", str(folder)]) == 0
    said = capsys.readouterr().out
    assert "broken.h5" in said
    assert "3 of 3" in said
    assert run(["list", str(folder / "nowhere")]) == 2

"""A session for other programs: what `labrig export --as` writes is what the session holds."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from drivers.plugins import OWN, Part
from labrig.cli.main import run
from labrig.errors import BadInputError, LabrigError
from labrig.exports.choice import FORMATS, export
from labrig.session import load_measurements, open_session, store_measurements
from labrig.session.tables import exchange
from tests.cases import few
from tests.labrig.session.measured import measurements
from tests.labrig.session.session_recording import record, small_schedule


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    path = tmp_path_factory.mktemp("exports") / "s.h5"
    record(path, small_schedule())
    store_measurements(path, measurements())
    return path


@pytest.mark.slow
def test_parquet_has_the_columns_and_values_of_csv(session, tmp_path):
    import pandas as pd

    export(session, tmp_path / "csv", "csv")
    written = export(session, tmp_path / "parquet", "parquet")
    assert {path.name for path in written} >= {"forces.parquet", "curves.parquet"}
    for path in written:
        table = pd.read_parquet(path)
        again = pd.read_csv(tmp_path / "csv" / f"{path.stem}.csv")
        assert list(table.columns) == list(again.columns)
        for name in table.select_dtypes("number"):
            np.testing.assert_array_equal(table[name].to_numpy(float), again[name].to_numpy(float))
        for name in {"configuration"} & set(again.columns):
            assert (table[name] == again[name]).all()
    assert "configuration" in pd.read_parquet(tmp_path / "parquet" / "forces.parquet").columns


@pytest.mark.slow
def test_xarray_has_named_dimensions_units_and_the_values_of_the_session(session, tmp_path):
    import xarray

    (path,) = export(session, tmp_path, "xarray")
    tree = xarray.open_datatree(path, engine="h5netcdf")
    force = tree["readings/force_N"]
    assert force.dims == ("reading",)
    assert force.attrs["units"] == "N"
    with open_session(session) as opened:
        rows = np.concatenate([run.readings for run in opened.runs])
        samples = np.concatenate([run.signal_V("force") for run in opened.runs])
    np.testing.assert_array_equal(force.values, rows["force_N"])
    np.testing.assert_array_equal(force.voltage_V.values, rows["voltage_V"])
    np.testing.assert_array_equal(tree["signals/force"].values, samples)
    for coordinate in (force.run, force.reading_index, tree["signals/force"].run):
        assert coordinate.attrs["comment"].startswith("counted from 0; labrig show and labrig mark")
    with h5py.File(session) as file:  # a time in the run, and one in the session
        np.testing.assert_allclose(force.session_s.values, file["session/data/time_s"][:])
    assert force.session_s.attrs == {"units": "s", "comment": "since the session's first event"}
    for times in (force.time_s, tree["signals/time_s"]):
        assert times.attrs == {"units": "s", "comment": "since time zero of the run"}
    curves = tree["curves"]
    measured = [c for c in load_measurements(session).conditions if c.curve is not None]
    first = curves["x_m"].values[curves["reading_index"].values == -1][0]
    np.testing.assert_array_equal(first[: len(measured[0].curve.x_m)], measured[0].curve.x_m)
    means = curves.to_dataset().isel(curve=curves["reading_index"].values == -1)
    for key, wanted in {"again": "run", "mounting": "mounting", "approach": "approach"}.items():
        assert [*means[key].values] == [getattr(c, wanted) for c in measured]


def read_documents(path):
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


@pytest.mark.slow
def test_bluesky_documents_are_valid_and_point_into_the_session(session, tmp_path):
    from event_model import DocumentNames, schema_validators

    (path,) = export(session, tmp_path, "bluesky")
    found = read_documents(path)
    for name, content in found:
        schema_validators[DocumentNames[name]].validate(content)
    names = [name for name, _ in found]
    assert names[0] == "start"
    assert names[-1] == "stop"
    with open_session(session) as opened:
        forces = [float(row["force_N"]) for run in opened.runs for row in run.readings]
    assert [c["data"]["force_N"] for name, c in found if name == "event"] == forces
    rows = {c["stream_resource"]: c["indices"]["stop"] for n, c in found if n == "stream_datum"}
    with h5py.File(session) as file:
        for name, content in found:
            if name == "stream_resource":
                assert content["uri"].endswith(session.name)
                dataset = file[content["parameters"]["dataset"]]
                assert len(dataset) == rows[content["uid"]]


@pytest.mark.thorough
@pytest.mark.filterwarnings("ignore")  # those of Tiled and what it stands on
def test_tiled_reads_back_what_the_session_holds(session, tmp_path):
    pytest.importorskip("tiled.server", reason="needs tiled[server] and bluesky-tiled-plugins")
    from bluesky_tiled_plugins import TiledWriter
    from tiled.catalog import in_memory
    from tiled.client import Context, from_context
    from tiled.server.app import build_app

    (path,) = export(session, tmp_path, "bluesky")
    storage = [str(tmp_path / "tiled"), f"duckdb:///{tmp_path}/tables.db"]
    catalog = in_memory(writable_storage=storage, readable_storage=[str(session.parent)])
    found = read_documents(path)
    with Context.from_app(build_app(catalog)) as context:
        client = from_context(context)
        writer = TiledWriter(client)
        for name, content in found:
            writer(name, content)
        run = client[found[0][1]["uid"]]
        streams = run.get("streams", run)
        force = np.asarray(streams["run_000_signals"]["force"].read()).ravel()
        images = np.asarray(streams["run_000_images"]["images"].read())
    with h5py.File(session) as file:
        np.testing.assert_array_equal(force, file["session/run_000/signals/force"][()])
        stored = file["session/run_000/frames/images"][()]
    np.testing.assert_array_equal(images.reshape(stored.shape), stored)


@pytest.mark.slow
def test_a_crate_names_the_session_its_licence_and_what_made_it(tmp_path):
    from rocrate.rocrate import ROCrate

    session = tmp_path / "s.h5"
    about = 'title = "Aged sheets"\nlicence = "CC-BY-4.0"\n[[people]]\nname = "Ada Example"\n'
    record(session, small_schedule(readings=1), texts={"about.toml": about, "sheet.toml": ""})
    written = export(session, tmp_path / "crate", "crate")
    assert {path.name for path in written} == {"ro-crate-metadata.json", "s.h5"}
    crate = ROCrate(tmp_path / "crate")
    assert crate.name == "Aged sheets"
    assert crate.license.id == "https://spdx.org/licenses/CC-BY-4.0"
    (action,) = [e for e in crate.get_entities() if e.type == "CreateAction"]
    assert action["name"] == "labrig run"
    assert action["result"].id == "s.h5"


@pytest.mark.slow
def test_a_crate_replaces_no_file(tmp_path):
    session = tmp_path / "S ü.h5"
    record(session, small_schedule(readings=1), texts={"sheet.toml": ""})
    (tmp_path / "crate").mkdir()
    (tmp_path / "crate" / "S ü.h5").write_text("mine")
    (tmp_path / "crate" / "notes.txt").write_text("mine, too")
    with pytest.raises(BadInputError, match=r"S ü\.h5 exists already"):
        export(session, tmp_path / "crate", "crate")
    assert (tmp_path / "crate" / "S ü.h5").read_text() == "mine"
    assert not (tmp_path / "crate" / "ro-crate-metadata.json").exists()
    (tmp_path / "crate" / "S ü.h5").unlink()
    written = export(session, tmp_path / "crate", "crate")
    assert {path.name for path in written} == {"ro-crate-metadata.json", "S ü.h5"}


@pytest.mark.thorough
@pytest.mark.slow
def test_a_crate_may_be_made_of_the_folder_of_its_session(tmp_path):
    session = tmp_path / "s.h5"
    record(session, small_schedule(readings=1), texts={"sheet.toml": ""})
    before = session.read_bytes()
    written = export(session, tmp_path, "crate")
    assert {path.name for path in written} == {"ro-crate-metadata.json", "s.h5"}
    assert session.read_bytes() == before


@pytest.mark.thorough
def test_tables_of_which_one_cannot_be_written_leave_none(session, tmp_path, monkeypatch):
    with monkeypatch.context() as patched:
        patched.setattr(exchange, "write_about_and_notes", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            export(session, tmp_path, "csv")
    assert list(tmp_path.iterdir()) == []
    written = export(session, tmp_path, "csv")
    kept = written[0].read_bytes()
    with pytest.raises(BadInputError, match="exists already"):
        export(session, tmp_path, "csv")
    assert written[0].read_bytes() == kept


@pytest.mark.slow
def test_a_missing_package_is_one_sentence_and_leaves_nothing(
    session, tmp_path, monkeypatch, capsys
):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    assert run(["export", str(session), "-o", str(tmp_path / "x"), "--as", "parquet"]) == 2
    said = capsys.readouterr().err
    assert 'pip install "labrig[dataframe]"' in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("extra", "told"),
    [
        ("maps", r'needs the package zarr; install it with: pip install "labrig-extra\[maps\]"\.'),
        ("", "needs the package zarr, which labrig-extra does not install; install it"),
    ],
)
def test_a_package_that_a_format_of_others_lacks_is_installed_with_their_distribution(
    session, tmp_path, monkeypatch, extra, told
):
    def write(_session, _folder):
        raise ModuleNotFoundError(name="zarr")

    lacking = SimpleNamespace(summary="", extra=extra, write=write)
    part = Part("lacking", lacking, "labrig-extra", "0.1")
    monkeypatch.setattr(type(FORMATS), "find", lambda *_: part)
    with pytest.raises(BadInputError, match=told):
        export(session, tmp_path, "lacking")


def test_a_format_that_is_not_there_is_refused_with_those_that_are(session, tmp_path):
    with pytest.raises(BadInputError, match=r"no export format 'netcdf'; choose one of: bluesky"):
        export(session, tmp_path, "netcdf")


@pytest.mark.slow
@pytest.mark.parametrize("name", few(["xarray", "bluesky"]))
def test_a_file_that_is_there_is_not_replaced(session, tmp_path, name):
    export(session, tmp_path, name)
    with pytest.raises(BadInputError, match="exists already"):
        export(session, tmp_path, name)


def test_a_format_that_does_not_say_what_it_wrote_is_named(session, tmp_path, monkeypatch):
    silent = SimpleNamespace(summary="Nothing.", extra="", write=lambda *_: None)
    parts = {"silent": Part("silent", silent, "labrig-extra", "0.1")}
    monkeypatch.setattr(type(FORMATS), "parts", lambda _: parts)
    monkeypatch.setattr(type(FORMATS), "find", lambda _, name: parts.get(name))
    with pytest.raises(LabrigError, match=r"'silent' of labrig-extra 0\.1 returned NoneType"):
        export(session, tmp_path, "silent")


def test_a_format_that_names_a_file_that_is_not_there_is_named(session, tmp_path, monkeypatch):
    def write(_session, folder):
        (folder / "here.txt").write_text("1")
        return [folder / "here.txt", folder / "not_there.txt"]

    ghostly = SimpleNamespace(summary="Nothing.", extra="", write=write)
    parts = {"ghostly": Part("ghostly", ghostly, "labrig-extra", "0.1")}
    monkeypatch.setattr(type(FORMATS), "parts", lambda _: parts)
    monkeypatch.setattr(type(FORMATS), "find", lambda _, name: parts.get(name))
    said = r"'ghostly' of labrig-extra 0\.1 did not write not_there\.txt, which it says it wrote"
    with pytest.raises(LabrigError, match=said):
        export(session, tmp_path, "ghostly")


@pytest.fixture
def of_others(monkeypatch):
    """Make a function the format 'theirs' of another distribution."""

    def made(write):
        theirs = SimpleNamespace(summary="Theirs.", extra="", write=write)
        parts = {"theirs": Part("theirs", theirs, "labrig-extra", "0.1")}
        monkeypatch.setattr(type(FORMATS), "parts", lambda _: parts)
        monkeypatch.setattr(type(FORMATS), "find", lambda _, name: parts.get(name))

    return made


def test_a_format_of_others_that_fails_half_way_leaves_nothing(session, tmp_path, of_others):
    def write(_session, folder):
        (folder / "half.txt").write_text("1")
        raise ValueError("the disk of my dreams is full")

    of_others(write)
    with pytest.raises(ValueError, match="dreams"):
        export(session, tmp_path / "new", "theirs")
    assert list(tmp_path.iterdir()) == []


def test_a_format_of_others_replaces_no_file_and_its_folders_are_kept(session, tmp_path, of_others):
    def write(_session, folder):
        (folder / "sub").mkdir()
        for name in ("sub/a.txt", "b.txt"):
            (folder / name).write_text("theirs")
        return [folder / "sub" / "a.txt", folder / "b.txt"]

    of_others(write)
    (tmp_path / "b.txt").write_text("mine")
    with pytest.raises(BadInputError, match=r"b\.txt exists already"):
        export(session, tmp_path, "theirs")
    assert [one.name for one in tmp_path.iterdir()] == ["b.txt"]
    assert (tmp_path / "b.txt").read_text() == "mine"
    (tmp_path / "b.txt").unlink()
    written = export(session, tmp_path, "theirs")
    assert written == [tmp_path / "sub" / "a.txt", tmp_path / "b.txt"]
    assert all(one.read_text() == "theirs" for one in written)


@pytest.mark.skipif(sys.platform == "win32", reason="there a link needs a privilege")
def test_files_of_others_are_found_where_they_are_if_the_folder_is_a_link(
    session, tmp_path, of_others
):
    def write(_session, folder):
        path = folder.resolve() / "a.txt"
        path.write_text("theirs")
        return [path]

    of_others(write)
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to("there")
    assert export(session, tmp_path / "link", "theirs") == [tmp_path / "link" / "a.txt"]


def test_a_file_in_the_way_of_a_folder_of_others_is_named(session, tmp_path, of_others):
    def write(_session, folder):
        (folder / "sub").mkdir()
        for name in ("a.txt", "sub/b.txt"):
            (folder / name).write_text("theirs")
        return [folder / "a.txt", folder / "sub" / "b.txt"]

    of_others(write)
    (tmp_path / "sub").write_text("mine")
    with pytest.raises(BadInputError, match=r"sub exists already"):
        export(session, tmp_path, "theirs")
    assert [one.name for one in tmp_path.iterdir()] == ["sub"]


def test_every_format_says_what_it_writes():
    assert {"bluesky", "crate", "csv", "parquet", "xarray"} <= set(FORMATS.parts())


def test_the_page_about_export_has_a_row_for_each_format():
    page = Path(__file__).parents[2] / "docs" / "howto" / "export.md"
    table = [line for line in page.read_text(encoding="utf-8").splitlines() if line[:1] == "|"]
    named = {line.split("`")[1] for line in table[2:]}
    assert named == {name for name, part in FORMATS.parts().items() if part.distribution == OWN}

"""`labrig batch` as a user types it: sessions, tables, models in; rows, table, summary out."""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

import pytest

from labrig.batch.conformance import faults
from labrig.batch.contract import (
    BatchAnswer,
    BatchInput,
    BatchItem,
    BatchTask,
    InputKind,
    option,
)
from labrig.batch.rows import PieceOutcome
from labrig.batch.run import BatchProgress
from labrig.batch.tasks.fit import FitEach
from labrig.batch.worker import Piece, do
from labrig.cli.batch import perform
from labrig.cli.main import run
from labrig.config import load_sheet
from labrig.errors import BadInputError
from labrig.model_file import save_model
from labrig.session import read_tables
from labrig.session.tables.write import write_tables
from labrig.testing import batch_task_faults
from model import fit
from model.discrepancy import diagnose
from tests.labrig.batch.costless import Costless
from tests.labrig.report_data import TEXTS, measure, session
from tests.labrig.session.session_recording import record, small_schedule

pytestmark = pytest.mark.slow  # processes are started
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "one.h5"
    record(path, small_schedule())
    return path


@pytest.fixture
def data(recorded, tmp_path, monkeypatch):
    """Three sessions in folders, a file that is none, and others."""
    for name in ("a.h5", "below/b.h5", "below/deeper/c.h5"):
        (tmp_path / "DATA" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(recorded, tmp_path / "DATA" / name)
    (tmp_path / "DATA" / "broken.h5").write_bytes(b"\x89HDF\r\n\x1a\n" + b"\x00" * 100)
    (tmp_path / "DATA" / "notes.txt").write_text("nothing")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    """Tables of two sheets, as another laboratory would send them."""
    folder = tmp_path_factory.mktemp("cases")
    for seed in (1, 2):
        case = folder / "CASES" / f"case{seed}"
        case.mkdir(parents=True)
        write_tables(measure("long", seed=seed, positions_m=(0.0, 0.015, 0.03)), case)
        (case / "sheet.toml").write_text(TEXTS["sheet.toml"])
        (case / "about.toml").write_text('title = "no sheet"\n')
    return folder


def table(folder):
    with (folder / "table.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_sessions_are_verified_and_a_faulty_file_is_one_row(data, capsys):
    pytest.importorskip("pyarrow")
    assert run(["batch", "verify", "DATA/**/*.h5", "--workers", "2"]) == 0
    said = capsys.readouterr().out
    assert "verify: 4 in all, 4 to do" in said
    rows = {row["name"]: row for row in table(data / "batch" / "verify")}
    assert list(rows) == sorted(rows)
    assert rows["DATA/below/deeper/c.h5"]["in_order"] == "true"
    assert rows["DATA/broken.h5"]["in_order"] == "false"
    assert str(data) not in rows["DATA/broken.h5"]["first_fault"]
    summary = json.loads((data / "batch" / "verify" / "summary.json").read_text())
    assert summary["counts"]["in_order"]["yes"]["rows"] == 3
    from pyarrow import parquet

    kept = parquet.read_table(data / "batch" / "verify" / "table.parquet").to_pylist()
    assert [row["in_order"] for row in kept] == [row["in_order"] == "true" for row in rows.values()]
    assert (data / "batch" / "verify" / "counts.png").exists()


@pytest.mark.thorough
def test_the_same_command_goes_on_and_a_dry_run_does_nothing(data, capsys):
    assert run(["batch", "verify", "DATA", "--dry-run", "--json"]) == 0
    todo = json.loads(capsys.readouterr().out)["todo"]
    assert len(todo) == 4
    assert not (data / "batch").exists()
    assert run(["batch", "verify", "DATA", "--limit", "1"]) == 0
    assert "3 left for later (--limit)" in capsys.readouterr().out
    assert run(["batch", "verify", "DATA", "--workers", "1"]) == 0
    assert "4 in all, 3 to do, 1 done before" in capsys.readouterr().out
    assert run(["batch", "verify", "DATA"]) == 0
    assert "4 in all, 0 to do, 4 done before" in capsys.readouterr().out
    assert len((data / "batch" / "verify" / "rows.jsonl").read_text().splitlines()) == 4


@pytest.mark.thorough
def test_a_batch_without_any_result_has_an_exit_code_that_says_so(data, capsys):
    whole = data / "DATA" / "a.h5"
    assert run(["batch", "report", "DATA/broken.h5"]) == 2
    assert "report: no result; the one row ended with an error" in capsys.readouterr().err
    assert run(["batch", "report", "DATA/broken.h5"]) == 2  # nothing to do, and nothing better
    assert run(["batch", "report", "DATA/broken.h5", str(whole.relative_to(data))]) == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["verify", "nothing/*.h5"], "nothing/*.h5: holds nothing to work on"),
        (["verify", "DATA/none.h5"], "DATA/none.h5: there is no such file"),
        (["verify", "DATA/notes.txt"], "DATA/notes.txt: cannot be used; a session (.h5) is needed"),
        (["design", "DATA"], "a model file is needed"),
        (["design", "DATA", "--section", "wide"], "--section 'wide'"),
        (["diagnose", "DATA", "--without", "magic"], "magic"),
        (["analyze", "DATA", "--extractor", "magic"], "magic"),
        (["fit", "DATA", "--columns", "strength=F"], "'strength' is no column of labrig's"),
        (["diagnose", "DATA", "--value", "configuration"], "write labrig's column, '='"),
        (["verify", "DATA", "-o", "DATA/notes.txt"], "a folder is needed"),
        (["verify", "DATA", "--scheduler", "tcp://h:1", "--workers", "2"], "give either"),
        (["verify"], "is missing"),
        (["sing", "DATA"], "there is no command 'sing'"),
    ],
)
def test_what_cannot_be_done_is_one_sentence(data, capsys, arguments, said):
    assert run(["batch", *arguments]) == 2
    assert said in " ".join(capsys.readouterr().err.split())


def test_tables_are_fitted_as_one_by_one(cases, monkeypatch, capsys):
    monkeypatch.chdir(cases)
    assert run(["batch", "fit", "CASES/*/sheet.toml", "-o", "out", "--workers", "2"]) == 0
    assert "bending stiffness B, long" in capsys.readouterr().out
    rows = table(cases / "out" / "fit")
    assert [row["name"] for row in rows] == ["CASES/case1/sheet.toml", "CASES/case2/sheet.toml"]
    for row in rows:
        case = (cases / row["name"]).parent
        alone = fit(
            read_tables(
                load_sheet(case / "sheet.toml"),
                *(case / f"{name}.csv" for name in ("forces", "curves", "signals")),
            )
        )
        assert float(row["B_Nm2[long]"]) == alone.configurations["long"].B.value
        assert float(row["EIBM_Nm[long, +2 V]"]) == alone.configurations["long"].eibm[2.0].value
        kept = json.loads((cases / "out/fit/each" / f"{row['name']}.json").read_text())
        assert kept == json.loads(json.dumps(alone.to_json()))
    assert run(["batch", "fit", "CASES", "-o", "out"]) == 0  # a folder: the same two
    assert "2 in all, 0 to do" in capsys.readouterr().out


@pytest.mark.thorough
def test_a_stiffness_that_no_force_measured_is_in_no_row(cases, tmp_path):
    case = shutil.copytree(cases / "CASES" / "case1", tmp_path / "case")
    (case / "forces.csv").unlink()
    (case / "signals.csv").unlink(missing_ok=True)
    item = BatchItem(source=BatchInput(InputKind.TABLES, case / "sheet.toml", "case"))
    columns = FitEach().work(item, tmp_path).columns
    assert columns["without_force"] == ["long"]
    assert not [name for name in columns if name.startswith(("B_Nm2", "EIBM_Nm"))]
    stated = FitEach(stiffness_Nm2=1e-6).work(item, tmp_path).columns
    assert stated["B_Nm2[long]"] == pytest.approx(1e-6)
    assert "EIBM_Nm[long, +2 V]" in stated


def test_a_task_that_returns_something_else_is_an_error_that_says_so(cases, tmp_path):
    class Wordy(Costless):
        """Return a word."""

        def work(self, item, folder):
            return "done"

    item = BatchItem(source=BatchInput(InputKind.TABLES, cases / "CASES/case1/sheet.toml", "case"))
    end = do(Piece(task=Wordy(), item=item, key="k", folder=tmp_path))
    assert "`work` returned str, not a BatchAnswer" in end.row.sentence


def test_a_task_with_a_cell_that_no_table_holds_loses_its_own_row_alone(cases, tmp_path):
    class Placed(Costless):
        """Return a path."""

        def work(self, item, folder):
            return BatchAnswer(columns={"k": 3, "place": item.source.path}, whole={})

    item = BatchItem(source=BatchInput(InputKind.TABLES, cases / "CASES/case1/sheet.toml", "case"))
    row = do(Piece(task=Placed(), item=item, key="k", folder=tmp_path / "case")).row
    assert row.outcome is PieceOutcome.FAULT
    assert "its column place holds a" in row.sentence
    assert "Path; a cell is a number, a text, True, False, None or a list of texts" in row.sentence
    assert b"its column place" in row.line()


def test_an_error_in_a_task_of_another_distribution_is_named_with_its_place(
    cases, tmp_path, monkeypatch
):
    info = tmp_path / "their_tasks-2.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: their-tasks\nVersion: 2.0\n")
    (info / "entry_points.txt").write_text("[labrig.batch_tasks]\nleave = their_tasks:TASK\n")
    (tmp_path / "their_tasks.py").write_text(
        "def work(item, folder):\n    raise RuntimeError('clerk left')\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))

    class Leaving(Costless):
        """Leave."""

        def work(self, item, folder):
            import_module("their_tasks").work(item, folder)

    item = BatchItem(source=BatchInput(InputKind.TABLES, cases / "CASES/case1/sheet.toml", "case"))
    end = do(Piece(task=Leaving(), item=item, key="k", folder=tmp_path))
    assert end.row.sentence == (
        "failed with RuntimeError: clerk left, in their-tasks 2.0 (their_tasks.py, line 2)."
    )


@pytest.mark.thorough
def test_tables_with_other_names_of_columns_are_read(cases, tmp_path):
    case = shutil.copytree(cases / "CASES" / "case1", tmp_path / "case")
    ours = (case / "forces.csv").read_text()
    (case / "forces.csv").write_text(ours.replace("force_mN", "F", 1))
    item = BatchItem(source=BatchInput(InputKind.TABLES, case / "sheet.toml", "case"))
    with pytest.raises(BadInputError, match="force_mN"):
        FitEach().work(item, tmp_path)
    renamed = FitEach(columns=("force_mN=F",)).work(item, tmp_path)
    (case / "forces.csv").write_text(ours)
    assert renamed.whole == FitEach().work(item, tmp_path).whole


@pytest.mark.thorough  # as fits are, in the test above
def test_a_diagnosis_in_a_batch_is_the_one_made_alone(cases, monkeypatch):
    monkeypatch.chdir(cases)
    assert run(["batch", "diagnose", "CASES/case1/sheet.toml", "-o", "out", "--workers", "1"]) == 0
    (row,) = table(cases / "out" / "diagnose")
    case = cases / "CASES" / "case1"
    names = ("forces", "curves", "signals")
    alone = diagnose(
        read_tables(load_sheet(case / "sheet.toml"), *(case / f"{name}.csv" for name in names))
    )
    kept = json.loads((cases / "out/diagnose/each/CASES/case1/sheet.toml.json").read_text())
    assert kept == json.loads(json.dumps(alone.to_json()))
    assert row["verdict"] == alone.verdict
    assert (cases / "out/diagnose/each/CASES/case1/sheet.toml.toml").exists()


_HIDE = """
import sys

class Hidden:
    names = {"cv2", "grpc", "nidaqmx", "serial", "fastapi", "starlette", "uvicorn", "websockets",
             "matplotlib", "google"}

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in self.names:
            raise ModuleNotFoundError(f"hidden: {name}", name=name)

sys.meta_path.insert(0, Hidden())
"""


@pytest.mark.thorough
@pytest.mark.parametrize("task", ["fit", pytest.param("diagnose", marks=pytest.mark.thorough)])
def test_workers_fit_and_diagnose_without_the_packages_of_a_rig(cases, tmp_path, task):
    (tmp_path / "sitecustomize.py").write_text(_HIDE)
    case = "CASES/case2/sheet.toml"
    environment = os.environ | {"PYTHONPATH": str(tmp_path)}
    command = [sys.executable, "-m", "labrig", "batch", task, case, "-o", str(tmp_path / "out")]
    ended = subprocess.run(
        command, cwd=cases, env=environment, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr
    assert "there are no figures: matplotlib is not installed." in ended.stdout
    (row,) = table(tmp_path / "out" / task)
    assert row["outcome"] == "done", row["why"]


@pytest.fixture(scope="module")
def model_file(tmp_path_factory):
    """A model of known sheets, the long one with constant EIBM."""
    path = tmp_path_factory.mktemp("models") / "model.toml"
    save_model(fit(measure("long", positions_m=(0.0, 0.015, 0.03))).model, path)
    return path


@pytest.mark.thorough
def test_a_coverage_study_counts_the_intervals_that_hold_the_truth(model_file, tmp_path, capsys):
    out = tmp_path / "out"
    command = ["batch", "simulate", str(model_file), "-o", str(out), "--count", "3"]
    assert run([*command, "--workers", "1"]) == 0
    assert "holds[B, long], of 3 rows" in capsys.readouterr().out
    rows = table(out / "simulate")
    assert [row["name"].split(" ", 1)[1] for row in rows] == [f"seed {k}" for k in range(3)]
    errors = [float(row["error_sigma[B, long]"]) for row in rows]
    assert len(set(errors)) == 3
    assert max(map(abs, errors)) < 5.0


@pytest.mark.thorough
def test_a_sweep_answers_each_combination(model_file, tmp_path):
    out = tmp_path / "out"
    command = ["batch", "design", str(model_file), "-o", str(out), "--workers", "1"]
    assert run([*command, "--section", "5:15", "--force-mN", "0.1", "--force-mN", "0.2"]) == 0
    rows = table(out / "design")
    assert [row["force_mN"] for row in rows] == ["0.1", "0.2"]
    areas = [float(row["least_area_m2[without elongation]"]) for row in rows]
    assert areas[1] > areas[0] > 0


@pytest.mark.thorough
def test_a_session_is_reported(tmp_path, monkeypatch):
    session(tmp_path / "made.h5", measure("long", positions_m=(0.0, 0.015, 0.03)))
    monkeypatch.chdir(tmp_path)
    assert run(["batch", "report", "made.h5", "--format", "svg"]) == 0
    (row,) = table(tmp_path / "batch" / "report")
    assert row["outcome"] == "done", row["why"]
    assert (tmp_path / "batch/report/each/made.h5/index.html").exists()


def test_how_long_a_batch_still_takes_is_said_once(monkeypatch, capsys):
    def a_slow_batch(_planned, _executor, _places, tell):
        began_s = time.monotonic()
        monkeypatch.setattr(time, "monotonic", lambda: began_s + 100.0)
        tell(BatchProgress(wanted=10, done=2, began_s=began_s), SimpleNamespace(sentence=""))

    monkeypatch.setattr("labrig.batch.run.run_batch", a_slow_batch)
    planned, request = SimpleNamespace(todo=[1]), SimpleNamespace(workers=1, scheduler=None)
    perform._work("fit", None, planned, request)
    assert "fit: 20 % - 2 of 10, 7 min left\n" in capsys.readouterr().err


def test_every_task_of_ours_keeps_to_the_contract():
    from labrig.batch.choice import BATCH_TASKS

    for part in BATCH_TASKS.parts().values():
        assert batch_task_faults(part.part) == []
    assert faults(Costless) == []


def test_what_is_wrong_with_a_task_is_said():
    assert "no subclass" in faults(3)[0]
    assert "does not define work" in faults(BatchTask)[0]

    class Local(Costless):
        """Made in a function."""

    assert any("inside a function" in one for one in faults(Local))


@dataclass(frozen=True, kw_only=True)
class Hasty(Costless):
    """With options and names of columns that do not fit."""

    counted = "even"

    count: int = option("pieces of each file", default=2.5)
    more: tuple[float, ...] = option("further ones", default=(1, 2))
    place: Path | None = option("where", default=None)
    name: str | None = option("a name", default=3)


def test_options_with_defaults_of_another_type_and_a_text_of_columns_are_faults():
    assert faults(Hasty) == [
        "`counted` must be a tuple of names of columns",
        "the default of its field count is 2.5, no int",
        "the default of its field name is 3, no str",
    ]

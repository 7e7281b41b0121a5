"""Streams, names and folders as few computers have them: each ends in a sentence, never a fault."""

from __future__ import annotations

import errno
import io
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from labrig.batch.rows import PieceOutcome, Row, row_of
from labrig.batch.table import write_csv
from labrig.cli.main import run
from labrig.errors import BadInputError
from labrig.files import check_free, write_text, write_zip
from labrig.panel.job.host import Host
from labrig.session.derived.arrays import measurements_from_tables, tables_from_measurements
from tests.cases import few
from tests.fits_unchecked import fits_unchecked
from tests.labrig.report_data import measure, session

pytestmark = pytest.mark.slow
POSIX = pytest.mark.skipif(os.name == "nt", reason="streams and names of POSIX")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("odd")
    session(made / "good.h5", measure("long"))
    assert run(["init", str(made / "rig"), "--simulated"]) == 0
    return made


def in_shell(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """Run a line of sh, in which $LABRIG is the command."""
    place = os.environ | {"LABRIG": f"{sys.executable} -m labrig", "PYTHONUNBUFFERED": ""}
    place |= environment
    place["PYTHONPATH"] = str(Path(__file__).resolve().parents[2])
    return subprocess.run(
        ["bash", "-c", line], cwd=folder, env=place, capture_output=True, check=False, timeout=120
    )


@POSIX
@pytest.mark.parametrize(
    "line",
    few(["plan rig/protocol.toml", "show good.h5 --json", "-h"], first=2),
)
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_pipe_whose_reader_has_ended_is_no_fault(
    folder: Path, line: str, unbuffered: str
) -> None:
    gone = f"exec {{fd}}> >(exit); sleep 0.3; $LABRIG {line} >&$fd"
    done = in_shell(gone, folder, PYTHONUNBUFFERED=unbuffered)
    assert (done.returncode, done.stderr) == (0, b"")


@POSIX
@pytest.mark.parametrize(
    "line", few(["show good.h5 --json", "-h", "plan rig/protocol.toml"], first=2)
)
def test_a_full_disk_behind_standard_output_is_one_sentence(folder: Path, line: str) -> None:
    done = in_shell(f"$LABRIG {line} > /dev/full", folder)
    assert done.stderr == b"labrig: standard output: cannot be written (the disk is full).\n"
    assert done.returncode == 5


@POSIX
def test_a_full_disk_behind_standard_error_does_not_change_the_code(folder: Path) -> None:
    assert in_shell("$LABRIG show gone.h5 2> /dev/full", folder).returncode == 2


@POSIX
@pytest.mark.parametrize(
    ("line", "code"),
    few(
        [
            ("show good.h5 >&-", 0),
            ("show gone.h5 2>&-", 2),
            ("plan rig/protocol.toml <&- >&- 2>&-", 0),
        ],
        first=2,
    ),
)
def test_streams_that_are_closed_are_no_fault(folder: Path, line: str, code: int) -> None:
    done = in_shell(f"$LABRIG {line}", folder)
    assert (done.returncode, done.stderr, done.stdout) == (code, b"", b"")


@POSIX
def test_no_file_is_opened_in_the_place_of_a_closed_stream(folder: Path) -> None:
    """What a library writes to standard error would stand in the middle of a session."""
    (folder / "look.py").write_text(
        "import os, pathlib, sys\n"
        "from labrig.cli import main\n"
        "sys.argv = ['labrig', '--version']\n"
        "try:\n"
        "    main()\n"
        "except SystemExit:\n"
        "    number = os.open('/dev/zero', os.O_RDONLY)\n"
        "    pathlib.Path('number').write_text(str(number))\n"
    )
    in_shell(f"{sys.executable} look.py <&- >&- 2>&-", folder)
    assert int((folder / "number").read_text()) > 2


ASCII = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


@POSIX
def test_a_name_that_the_locale_lacks_is_printed_as_it_is(folder: Path) -> None:
    name = "Größe 中.toml"
    (folder / name).write_bytes((folder / "rig" / "protocol.toml").read_bytes())
    wrong = in_shell(f"$LABRIG show '{name}'", folder, **ASCII)
    assert name.encode() in wrong.stderr
    made = in_shell(f"$LABRIG export good.h5 -o '{name}.dir' --as csv", folder, **ASCII)
    assert f"wrote {name}.dir".encode() in made.stdout


def test_signs_that_standard_error_lacks_become_plain_ones() -> None:
    name = "36 \N{MICRO SIGN}N \N{PLUS-MINUS SIGN} 1 m\N{SUPERSCRIPT THREE} 漢.h5"
    done = subprocess.run(
        [sys.executable, "-m", "labrig", "show", name],
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        capture_output=True,
        check=False,
    )
    assert done.stderr.startswith(b"labrig: 36 uN +/- 1 m^3 ?.h5: there is no such file.")


@POSIX
@pytest.mark.usefixtures("words_only")
def test_a_report_of_a_session_whose_name_is_no_text_is_written(folder: Path) -> None:
    """A name of an old system, in Latin-1."""
    named = _in_latin_1(folder, ".h5")
    named.write_bytes((folder / "good.h5").read_bytes())
    with fits_unchecked():
        assert run(["report", str(named), "-o", str(folder / "report-of-it")]) == 0
    assert "Gr\N{REPLACEMENT CHARACTER}" in (folder / "report-of-it/index.html").read_text("utf-8")


@POSIX
def test_a_note_that_was_typed_under_a_locale_without_its_letters_is_kept(folder: Path) -> None:
    (folder / "noted.h5").write_bytes((folder / "good.h5").read_bytes())
    done = in_shell("$LABRIG note noted.h5 'trocken: µ → 中'", folder, **ASCII)
    assert (done.returncode, done.stderr) == (0, b"")
    shown = in_shell("$LABRIG show noted.h5 --json", folder).stdout
    assert b"trocken" in shown
    assert b"\\u4e2d" in shown or "中".encode() in shown


@POSIX
def test_a_pipe_in_the_place_of_a_session_is_refused_and_not_waited_for(folder: Path) -> None:
    os.mkfifo(folder / "fifo.h5")
    done = in_shell("timeout 20 $LABRIG show fifo.h5", folder)
    assert done.stderr == (
        b"labrig: fifo.h5: this is a device or a pipe, an ordinary file is needed.\n"
    )


@POSIX
def test_a_pipe_is_written_into_and_not_replaced(folder: Path) -> None:
    fifo = folder / "fifo"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    write_text(fifo, "image,state\n")
    assert fifo.is_fifo()
    assert os.read(reader, 100) == b"image,state\n"
    os.close(reader)


@POSIX
def test_a_pipe_is_free_in_a_folder_that_takes_no_file(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    os.mkfifo(folder / "free")
    monkeypatch.setattr(os, "access", lambda path, _mode: Path(path) != folder)
    check_free(folder / "free", force=True)


@POSIX
def test_an_archive_does_not_replace_a_pipe(folder: Path) -> None:
    os.mkfifo(folder / "fifo.zip")
    with pytest.raises(BadInputError, match="this is a device or a pipe"):
        write_zip(folder / "fifo.zip", [])
    assert (folder / "fifo.zip").is_fifo()


def _in_latin_1(folder: Path, ending: str) -> Path:
    """Return a name of an old system, whose letters are no UTF-8."""
    return folder / os.fsdecode(b"Gr\xf6\xdfe" + ending.encode())


@POSIX
def test_what_was_measured_in_a_session_whose_name_is_no_text_can_be_stored(tmp_path: Path) -> None:
    measured = replace(measure("long"), source=str(_in_latin_1(tmp_path, ".h5")))
    kept = measurements_from_tables(tables_from_measurements(measured))
    assert kept.source.endswith("Gr\N{REPLACEMENT CHARACTER}\N{REPLACEMENT CHARACTER}e.h5")


@POSIX
def test_one_file_whose_name_is_no_text_is_named_and_the_others_are_listed(
    folder: Path, tmp_path: Path
) -> None:
    for name in (_in_latin_1(tmp_path, ".h5"), tmp_path / "good.h5"):
        name.write_bytes((folder / "good.h5").read_bytes())
    said = in_shell("$LABRIG list .", tmp_path)
    assert said.returncode == 0
    assert b"good.h5" in said.stdout
    assert b"e.h5: its name holds bytes that are no letters here; rename it" in said.stderr


@POSIX
@pytest.mark.parametrize("kind", few(["video", "crate"]))
def test_an_export_under_a_name_that_is_no_text_is_made_or_refused(
    folder: Path, tmp_path: Path, kind: str
) -> None:
    """OpenCV would end the process."""
    path = _in_latin_1(tmp_path, ".h5")
    path.write_bytes((folder / "good.h5").read_bytes())
    done = in_shell(f"$LABRIG export Gr*.h5 -o Gr*.h5.of --as {kind}", tmp_path)
    assert done.returncode in {0, 2}
    assert b"should not have happened" not in done.stderr


@POSIX
def test_a_film_under_a_name_that_is_no_text_is_refused(folder: Path, tmp_path: Path) -> None:
    film = _in_latin_1(tmp_path, ".avi")
    film.write_bytes(b"RIFF")
    done = in_shell(f"$LABRIG curves Gr*.avi --optics {folder}/rig/optics.json --to-end", tmp_path)
    assert b"holds bytes that are no letters" in done.stdout


@POSIX
def test_a_row_of_a_batch_holds_a_name_that_is_no_text(tmp_path: Path) -> None:
    name = os.fsdecode(b"Gr\xf6\xdfe.h5")
    row = Row(name=name, key="1", outcome=PieceOutcome.DONE)
    assert row_of(row.line()) == row
    write_csv(tmp_path / "all.csv", [row])
    assert "Gr\N{REPLACEMENT CHARACTER}" in (tmp_path / "all.csv").read_text("utf-8")


@POSIX
def test_a_working_folder_that_somebody_has_removed_is_told(folder: Path) -> None:
    done = in_shell("mkdir gone; cd gone; rmdir ../gone; $LABRIG list .", folder)
    assert done.returncode == 2
    assert done.stderr == b"labrig: the folder you are in has been removed; change to another.\n"


def test_a_users_own_settings_of_matplotlib_change_no_figure(folder: Path, tmp_path: Path) -> None:
    plan = [sys.executable, "-m", "labrig", "plan", str(folder / "rig" / "protocol.toml")]
    there = tmp_path / "matplotlibrc"
    drawn = []
    for text, backend in ("", "agg"), ("text.usetex: True\naxes.facecolor: red\n", "gone"):
        there.write_text(text)
        environment = os.environ | {"MATPLOTLIBRC": str(there), "MPLBACKEND": backend}
        picture = tmp_path / f"{backend}.svg"
        subprocess.run([*plan, "--picture", str(picture)], env=environment, check=True)
        drawn.append(picture.read_bytes())
    assert drawn[0] == drawn[1]


def test_a_warning_reaches_the_page_when_the_disk_of_the_jobs_log_is_full(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Full(io.StringIO):
        def write(self, _text: str) -> int:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    published: list[dict[str, object]] = []
    monkeypatch.setattr(sys, "stderr", Full())
    Host.warn(cast("Host", SimpleNamespace(publish=published.append)), "the disk is full")
    assert published[0]["text"] == "the disk is full"


@pytest.mark.parametrize("home", ["unknown", "relative"])
def test_a_user_without_a_home_has_no_cache_and_no_fault(
    folder: Path, monkeypatch: pytest.MonkeyPatch, home: str
) -> None:
    """As in a container that runs as a number which it does not know."""

    def nowhere(_cls: type[Path]) -> Path:
        raise RuntimeError("Could not determine home directory.")

    for name in ("LABRIG_CACHE", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    found = nowhere if home == "unknown" else lambda _cls: Path("home")
    monkeypatch.setattr(Path, "home", classmethod(found))
    monkeypatch.chdir(folder)
    assert run(["list", "rig"]) == 0
    assert not (folder / "home").exists()

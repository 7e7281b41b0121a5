"""CSV tables and model files that are broken in every way."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import pytest

from labrig.config.templates import template_text
from labrig.errors import BadInputError
from labrig.model_file import load_model, model_text
from labrig.session import write_tables
from model import ModelError
from tests.cases import few
from tests.fuzz.mangle import DEEP, bytes_of, text_of
from tests.fuzz.told import small_and_soon, told
from tests.labrig.report_data import truth
from tests.labrig.session.measured import measurements

TABLES = ("forces.csv", "curves.csv", "signals.csv")
CASES = 15  # of each kind of file and of damage


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Sound tables, and the sheet they belong to."""
    folder = tmp_path_factory.mktemp("tables")
    write_tables(measurements(), folder)
    (folder / "sheet.toml").write_text(template_text("sheet.toml"))
    return folder


def imported(folder: Path, output: Path) -> int:
    """Import all three tables; the exit code."""
    output.unlink(missing_ok=True)
    tables = [f"--{name.removesuffix('.csv')}={folder / name}" for name in TABLES]
    return told("import", f"--sheet={folder / 'sheet.toml'}", *tables, "-o", output)[0]


@pytest.mark.slow
@pytest.mark.parametrize("kind", few(["text", "bytes"], first=2))
@pytest.mark.parametrize("name", few(TABLES, first=2))
def test_a_damaged_table_is_refused_in_words_or_read(
    sound: Path, tmp_path: Path, name: str, kind: str
) -> None:
    for each in sound.iterdir():
        (tmp_path / each.name).write_bytes(each.read_bytes())
    assert imported(tmp_path, tmp_path / "s.h5") == 0
    raw = (sound / name).read_bytes()
    dice = random.Random(name + kind)
    codes = []
    for _ in range(CASES):
        (tmp_path / name).write_bytes(_damaged(raw, kind, dice))
        codes.append(imported(tmp_path, tmp_path / "s.h5"))
        if codes[-1] == 0:  # what was read must be of use, too
            told("show", tmp_path / "s.h5", codes={0})
    assert 2 in codes


def _damaged(raw: bytes, kind: str, dice: random.Random) -> bytes:
    if kind == "bytes":
        return bytes_of(raw, dice)
    return text_of(raw.decode(), dice).encode("utf-8", "surrogatepass")


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    few(
        [
            "",
            "\0" * 100,
            '"' * 1000,
            '"' + "x" * 300_000 + '"',
            "," * 100_000,
            "configuration\n" * 10,
            "configuration,position_mm,voltage_V,reading,force_mN\n" + "long,5,2,1," + "9" * 5000,
            "configuration,position_mm,voltage_V,reading,force_mN\n" + f"long,5,2,{'9' * 5000},1",
            "configuration,position_mm,voltage_V,reading,force_mN\nlong,1e999999999,2,1,1",
            "configuration,position_mm,voltage_V,reading,force_mN\nlong,5,2,99999999999999999999,1",
        ],
        first=3,
    ),
)
def test_a_table_of_nonsense_is_refused(sound: Path, tmp_path: Path, text: str) -> None:
    (tmp_path / "forces.csv").write_text(text)
    arguments = (f"--sheet={sound / 'sheet.toml'}", f"--forces={tmp_path / 'forces.csv'}")
    told("import", *arguments, "-o", tmp_path / "s.h5", codes={2})
    assert not (tmp_path / "s.h5").exists()


def used(path: Path) -> bool:
    """Load a model and predict with it; whether it was refused in words."""
    with small_and_soon():
        try:
            model = load_model(path)
            for name in model.sheets:
                for position_m in (0.0, 0.02):
                    model.predict(name, position_m, 2.0)
        except (BadInputError, ModelError) as fault:
            return bool(str(fault))
    return False


@pytest.mark.slow
def test_a_damaged_model_file_is_refused_in_words_or_predicts(tmp_path: Path) -> None:
    model = truth("long", "short")
    model.predict("long", 0.0, 2.0)  # compiles, which may take long
    sound, path = model_text(model), tmp_path / "model.toml"
    path.write_text(sound)
    assert not used(path)
    dice = random.Random(11)
    refused = 0
    for _ in range(3 * CASES):
        path.write_bytes(text_of(sound, dice).encode("utf-8", "surrogatepass"))
        refused += used(path)
    assert refused > CASES / 2


@pytest.mark.parametrize("damage", [lambda _: "a = " + "[" * DEEP, lambda t: t + t, lambda _: ""])
def test_a_model_file_of_nonsense_is_refused(tmp_path: Path, damage: Callable[[str], str]) -> None:
    path = tmp_path / "model.toml"
    path.write_text(damage(model_text(truth("long", "short"))))
    assert used(path)

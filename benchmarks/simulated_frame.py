"""A frame of the simulated camera, with drawing random numbers for each of its pixels."""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

from time import process_time

import numpy as np

from benchmarks.report import Report, Table
from sim_hardware.optics import OpticsSettings, Renderer

FRAMES = 60
SHEET_M = np.column_stack((np.linspace(0, 0.05, 60), 0.004 * np.linspace(0, 1, 60) ** 2))
MOVING_M = [SHEET_M * [1, 1 + 0.1 * k] for k in range(3)]
CONTACT = (0.0395, 0.0026, 0.14)


def measure() -> Report:
    """Median CPU time of both, in turns."""
    renderer, random = Renderer(OpticsSettings()), np.random.default_rng(0)
    size = renderer.render([SHEET_M], CONTACT, 0).shape  # compiled from here on
    frames_s, peers_s = [], []
    for number in range(FRAMES):
        began_s = process_time()
        renderer.render(MOVING_M, CONTACT, number)
        drawn_s = process_time()
        random.standard_normal(size)
        frames_s.append(drawn_s - began_s)
        peers_s.append(process_time() - drawn_s)
    frame_ms, peer_ms = (1e3 * float(np.median(each)) for each in (frames_s, peers_s))
    row = (
        f"{size[1]} x {size[0]}",
        f"{frame_ms:.2f}",
        f"{peer_ms:.2f}",
        f"{frame_ms / peer_ms:.2f}",
    )
    columns = ("pixels", "frame, ms", "random numbers, ms", "ratio")
    table = Table(f"One frame of a moving sheet, CPU, median of {FRAMES}", columns, (row,))
    return Report((table,), {"ratio": frame_ms / peer_ms})

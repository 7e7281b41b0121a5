"""Predictions of an array of positions in one call, with as many calls for one position each."""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

from time import process_time

import numpy as np

from benchmarks.report import Report, Table
from labrig.api.sheet import sheet as sheet_of
from model import predict

COUNTS = (20, 200, 2000)


def measure() -> Report:
    """CPU seconds of both, by the number of positions."""
    sheet = sheet_of(
        free_length_mm=50,
        width_mm=11,
        thickness_mm=0.21,
        E_Pa=150e6,
        EIBM_Nm={2.0: 36e-6, -2.0: -28e-6},
    )
    rows, ratios = [], {}
    sheet.predict("sheet", np.linspace(0.0, 0.03, 3), 2.0)  # compiled from here on
    for count in COUNTS:
        positions_m = np.linspace(0.0, 0.03, count)
        began_s = process_time()
        apart = [predict(sheet, "sheet", float(p), 2.0).F_N for p in positions_m]
        middle_s = process_time()
        batch = sheet.predict("sheet", positions_m, 2.0)
        apart_s, batch_s = middle_s - began_s, process_time() - middle_s
        worst_N = float(np.max(np.abs(batch.F_N - apart)))
        ratios[count] = apart_s / batch_s
        times = (f"{1e3 * apart_s:.1f}", f"{1e3 * batch_s:.1f}", f"{apart_s / batch_s:.1f}")
        rows.append((str(count), *times, f"{1e3 * worst_N:.1e}"))
    columns = ("positions", "one by one, ms", "in one call, ms", "ratio", "largest difference, mN")
    return Report(
        (Table("Predictions of one sheet, CPU", columns, tuple(rows)),), {"ratio": ratios}
    )

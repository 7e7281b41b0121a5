"""Every page of the panel with something to show, and what to wait for on each."""

from __future__ import annotations

from functools import cache
from typing import Any

from labrig.analysis.results import converging, result_of
from labrig.panel.pages.interface import listing
from model import fit
from tests.labrig.report_data import measure
from tests.panel_browser.fake_panel import FakePanel

SESSION = {
    "name": "a.h5", "started": "2026-11-21T12:00:00Z", "sheet": ["long"], "protocol": "pulse_train",
    "outcome": "aborted", "output": "safe", "reason": "STOP", "simulated": True, "runs": 14,
    "runs_complete": 5, "readings": 160, "invalid": 2, "bytes": 12345678, "duration_s": 930.0,
    "analysed": True, "largest_force_mN": 2.43, "scatter_mN": 0.017, "error": None,
    "fit": {"long": {
        "B_Nm2": 1.2755e-6, "B_sigma": 6.8e-9, "E_Pa": 1.5e8, "EIBM_Nm": {"2.0": 36.6e-6},
        "EIBM_sigma": {"2.0": 1.2e-7}, "rmse_force_mN": 0.022, "rmse_curve_mm": 0.032}},
}  # fmt: skip
MEAN = {"force_mN": 1.0, "scatter_mN": 0.1, "readings": 10}
ROW = {"configuration": "long", "position_mm": 5, "voltage_V": 2.0, "a": MEAN, "b": MEAN}
PAGES = {
    "run": ".mean", "new": "[data-key='pulse_s']", "load-cell": ".chart canvas", "camera": ".step",
    "library": ".library-table tbody tr", "session?name=a.h5": ".facts dd", "log": "main table",
    "compare?a=a.h5&b=b.h5": ".compare-forces tbody tr", "replay?session=a.h5": ".transport",
    "result?session=a.h5": ".result-settling canvas",
}  # fmt: skip
DIAGNOSIS = {
    "verdict": "effect_named",
    "title": "an effect is named",
    "sentences": ["Verdict: nonuniform_eibm is missing."],
    "next": ["Measure next: 7 further positions. The candidates are 2.1 sigma apart now."],
}


def fill(fake: FakePanel) -> None:
    """Give a panel something to show on every page."""
    fake.answers["GET", "/api/library"] = {"sessions": [SESSION], "total": 1, "damaged": 0}
    fake.answers["GET", "/api/library/session"] = {
        **SESSION,
        "log": [{"time_s": 1, "text": "begun"}],
    }
    fake.answers["GET", "/api/library/compare"] = {"a": SESSION, "b": SESSION, "rows": [ROW]}
    fake.answers["GET", "/api/result"] = result()
    action = {"wall": "2026-11-21T12:00:00Z", "who": "Ann", "what": "started a run"}
    fake.answers["GET", "/api/log"] = {"actions": [action]}
    points = [{"load_mN": load, "mV": 3.0, "off_mN": 0.01} for load in (0, 10, 20)]
    fit = {"sensitivity_V_per_N": 51.0, "sensitivity_sigma_V_per_N": 0.1}
    fit |= {"offset_V": 0.0, "offset_sigma_V": 0.001}
    weighing = {"type": "weighing", "points": points, "wanted": [0, 10, 20, 0]}
    prompt = {
        "type": "prompt", "time_s": 1, "prompt": 99, "kind": "moisten", "configuration": "long",
        "text": "Moisten the sheet.", "position_mm": None, "load_mN": None, "log": "asked",
    }  # fmt: skip
    fake.greeting += [{**weighing, "fit": fit, "finished": False}, prompt]


def every_page() -> dict[str, str]:
    """Return what to wait for on each page that the server lists, ours or not."""
    known = {name.partition("?")[0] for name in PAGES}
    names = [page["name"] for page in listing("rig")["pages"]]
    return {**PAGES, **{name: "main h1, main h2" for name in names if name not in known}}


@cache
def result() -> dict[str, Any]:
    """Return the result of a made-up session."""
    measured = measure()
    return {
        **result_of(
            measured, session="a.h5", fitted=fit(measured), convergence=converging(measured),
            diagnosis=DIAGNOSIS, missing=[{"kind": "report", "text": "There is no report yet."}],
        ),
        "complete": True,
    }  # fmt: skip

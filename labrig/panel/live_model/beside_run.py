"""The dynamic model of a run that is going on, fed with its writes, its signals and its curves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drivers.interfaces import FloatArray
from labrig.errors import LabrigError
from labrig.model_file import load_model
from labrig.panel.live.event_stream import ESTIMATES, MOTION, Message
from labrig.panel.live.optics_message import optics_of
from labrig.panel.live.prediction import rms_distance, rounded_px
from labrig.panel.live.strip_chart import BIN_S, PREDICTED, StripChart
from labrig.panel.live_model.running_error import OVER_S, RunningError, white_noise
from labrig.vision import Optics
from model import ModelError, SheetModel
from model.dynamics import DynamicBeam
from model.dynamics.online import GRID_S, MEAN_S, Drive, Estimate, GridMotion, RunEstimator

FORCE, CURRENT = "force_mN", "current_mA"
CURVE_EVERY_S = 0.2  # the estimate takes no more curves than that
TRACE_EVERY_S = 1.0
MOST_TRACE = 600  # rows; beyond, every other one goes
MOST_BEHIND_S = 120.0  # a model that is chosen later in a run begins with the next one
_NOTHING_CHOSEN = ""


@dataclass(frozen=True)
class ModelAnswer:
    """What the pages are told: a message, a piece of the strip chart, the trace if it has grown."""

    motion: Message
    strip: StripChart | None = None
    estimates: Message | None = None


class EstimateTrace:
    """Estimates of the session so far; a row: see `docs/reference/panel_messages.md`."""

    columns = ("time_s", "configuration", "B", "B_sigma", "moment", "moment_sigma")

    def __init__(self) -> None:
        self._rows: list[list[Any]] = []
        self._values: dict[str, dict[str, float]] = {}  # of the model, by configuration
        self._has_grown = False

    def set_model(self, configuration: str, beam: DynamicBeam) -> None:
        """Note what the rows' ratios refer to."""
        self._values[configuration] = {
            "B_Nm2": beam.material.B_Nm2,
            "moment_per_volt_Nm": beam.moment_per_volt_Nm[0],
        }

    def add(self, time_s: float, configuration: str, estimate: Estimate) -> None:
        """Add a row."""
        (B, moment), (B_sigma, moment_sigma) = estimate.ratios, estimate.sigmas
        numbers = [round(x, 5) for x in (B, B_sigma, moment, moment_sigma)]
        self._rows.append([round(time_s, 2), configuration, *numbers])
        if len(self._rows) > MOST_TRACE:
            self._rows = self._rows[::2]
        self._has_grown = True

    def news(self) -> Message | None:
        """Return the message of the whole trace; None where it is that of the last time."""
        if not self._has_grown:
            return None
        self._has_grown = False
        return {
            "type": ESTIMATES,
            "model": self._values,
            "columns": list(self.columns),
            "rows": self._rows,
        }


class FollowedRun:
    """One run: the model's motion, the estimate, the errors."""

    def __init__(self, index: int, zero_s: float, motion: GridMotion, estimator: RunEstimator):
        self.index, self.zero_s = index, zero_s
        self.motion, self.estimator = motion, estimator
        self.drive = Drive()
        self.force, self.shape = RunningError(), RunningError()
        self.noise_mN: list[float] = []
        self.bins: list[tuple[float, float]] = []  # of the force, not yet in the estimate
        self.sent = 0  # bins of the prediction that the pages have
        self.curve_s = -np.inf
        self.traced_s = -np.inf
        self.drawn: Message | None = None
        self.stopped = False


class ModelBesideRun:
    """Follows one session after the other; `take` and `follow` never raise."""

    def __init__(self) -> None:
        self._model: SheetModel | None = None
        self._why = _NOTHING_CHOSEN
        self._optics: Optics | None = None
        self._runs: dict[int, Message] = {}  # of the plan
        self._run: FollowedRun | None = None
        self._now: int | None = None  # run that goes on
        self._forget()

    def _forget(self) -> None:
        self._run, self._now = None, None
        self._estimates: dict[str, tuple[float, Estimate]] = {}  # by configuration, and when
        self._trace = EstimateTrace()

    def choose(self, path: str | None) -> None:
        """Take another model; it begins with the next run."""
        self._model, self._why = None, _NOTHING_CHOSEN
        self._forget()
        if path is None:
            return
        try:
            self._model = load_model(Path(path))
        except LabrigError as error:
            self._why = str(error)
            return
        if not self._model.dynamic:
            self._model = None
            self._why = (
                f"{Path(path).name} knows the sheet at rest only; fit it in time with "
                "labrig fit --dynamic."
            )
            return
        self._guarded(lambda: self._prepare(Path(path).name))

    def _prepare(self, name: str) -> None:
        """Load what a run needs, and learn whether the model can be computed."""
        assert self._model is not None  # noqa: S101 - for the type checker
        for configuration in self._model.dynamic:
            try:
                GridMotion(*self._model.moving(configuration, None)).advance(Drive(), GRID_S)
            except ModelError as error:
                raise ModelError(f"{name}: {configuration}: {error}") from None

    def setup(self, message: Message) -> None:
        """Take the camera."""
        self._optics = optics_of(message)

    def take(self, message: Message) -> None:
        """Follow a message of the session."""
        kind = message["type"]
        if kind == "story":
            self._forget()
        elif kind == "plan":
            rows = [*message["runs"], *message["repeats"]]
            self._runs = {row["run"]: row for row in rows}
        elif kind == "run_started":
            self._guarded(lambda: self._start(message))
        elif kind == "voltage" and self._run is not None and message["run"] == self._run.index:
            self._run.drive.add(float(message["run_s"]), float(message["sheet_V"]))
        elif kind == "load_cell" and self._run is not None:
            self._fail("the load cell moves in this run; the model goes on with the next run.")
        elif kind == "run_stopped" and self._run is not None:
            self._end_run()

    def follow(self, strip: StripChart | None, curve: Message | None) -> ModelAnswer:
        """Go on as far as the signals go, and compare with them and with a curve."""
        pieces: list[StripChart] = []
        self._guarded(lambda: self._go_on(strip, curve, pieces))
        return ModelAnswer(self._message(), pieces[0] if pieces else None, self._trace.news())

    # ------------------------------------------------------------------------------------- a run

    def _guarded(self, work: Callable[[], None]) -> None:
        """Do it; what fails is a sentence, until the next run."""
        try:
            work()
        except (ModelError, LabrigError, ValueError, LookupError, ArithmeticError) as error:
            self._fail(f"{str(error).rstrip('.')}; the model goes on with the next run.")

    def _fail(self, why: str) -> None:
        self._end_run()
        self._run, self._why = None, why

    def _start(self, started: Message) -> None:
        self._end_run()
        self._run, self._now = None, int(started["run"])
        if self._model is None:
            return
        planned = self._runs[self._now]
        name, position_mm = planned["configuration"], planned["position_mm"]
        if started.get("stage_position_mm") is not None:
            position_mm = started["stage_position_mm"]
        beam, rolls = self._model.moving(name, None if position_mm is None else position_mm / 1e3)
        zero_s = float(started["time_s"])
        self._trace.set_model(name, beam)
        known = self._estimates.get(name)
        prior = Estimate.unknown() if known is None else known[1].after(zero_s - known[0])
        estimator = RunEstimator(beam, rolls, prior)
        self._run = FollowedRun(self._now, zero_s, GridMotion(beam, rolls), estimator)
        self._why = ""

    def _end_run(self) -> None:
        run = self._run
        if run is not None and not run.stopped:
            run.stopped = True
            at_s = run.zero_s + max(run.motion.time_s, 0.0)
            self._estimates[self._configuration] = (at_s, run.estimator.estimate)

    @property
    def _configuration(self) -> str:
        assert self._run is not None  # noqa: S101 - for the type checker
        return str(self._runs[self._run.index]["configuration"])

    def _go_on(
        self, strip: StripChart | None, curve: Message | None, pieces: list[StripChart]
    ) -> None:
        run = self._run
        if run is None or run.stopped:
            return
        if strip is not None and strip.run == run.index and strip.values.shape[1]:
            self._take_signals(run, strip, pieces)
        if curve is not None and curve.get("run") == run.index and curve.get("time_s") is not None:
            self._take_curve(run, curve)
        if run.motion.slipped_s is not None:
            at_s = run.motion.slipped_s
            self._fail(
                f"the model's sheet slips out of the rolls {at_s:.2f} s after the run's beginning; "
                "the model goes on with the next run."
            )

    def _take_signals(self, run: FollowedRun, strip: StripChart, pieces: list[StripChart]) -> None:
        times = strip.values[0].astype(float)
        times = np.round(times / GRID_S) * GRID_S
        if times[-1] < 0.0:
            return  # from before the run's beginning: the model begins there
        if times[-1] - run.motion.time_s > MOST_BEHIND_S:
            raise ModelError(f"the model is more than {MOST_BEHIND_S:g} s behind the run")
        run.motion.advance(run.drive, float(times[-1]) + 0.5 * GRID_S)
        if round(float(times[-1]) / BIN_S + 0.5) > run.sent:
            pieces.append(self._predicted(run, strip, float(times[-1])))
        self._trace_estimate(run)
        if FORCE not in strip.keys or self._is_free(run):
            return
        force_mN = _middle(strip, FORCE)
        at = np.round(times / GRID_S).astype(int)
        inside = at >= 0
        first = max(int(at[0]), 0)
        predicted_mN = 1e3 * run.motion.force_N(first)[np.maximum(at - first, 0)]
        for t, error in zip(times[inside], (predicted_mN - force_mN)[inside], strict=True):
            run.force.add(float(t), float(error))
        run.noise_mN = [*run.noise_mN, *force_mN[inside].tolist()][-round(OVER_S / BIN_S) :]
        run.bins += zip(times[inside].tolist(), force_mN[inside].tolist(), strict=True)
        self._estimate_force(run)

    def _is_free(self, run: FollowedRun) -> bool:
        return self._runs[run.index]["position_mm"] is None

    def _predicted(self, run: FollowedRun, strip: StripChart, until_s: float) -> StripChart:
        """Return the prediction that the pages do not have yet, at the middles of the bins."""
        keys = tuple(key for key in (FORCE, CURRENT) if key in strip.keys)
        count = round(until_s / BIN_S + 0.5)  # bins up to the last one
        first, run.sent = run.sent, max(run.sent, count)
        t = (np.arange(first, run.sent) + 0.5) * BIN_S
        begin = round(first * BIN_S / GRID_S)
        at = np.minimum(np.round(t / GRID_S).astype(int), run.motion.count - 1) - begin
        by = {FORCE: 1e3 * run.motion.force_N(begin), CURRENT: 1e3 * run.motion.current_A(begin)}
        rows = [t, *(by[key][at] for key in keys for _ in range(2))]
        return StripChart(
            run=run.index,
            keys=keys,
            values=np.array(rows, dtype=np.float32),
            fresh=first == 0,
            kind=PREDICTED,
        )

    def _estimate_force(self, run: FollowedRun) -> None:
        """Give the estimate each whole 0.1 s."""
        sigma_mN = white_noise(np.array(run.noise_mN))
        while run.bins and run.bins[-1][0] - run.bins[0][0] >= MEAN_S - 0.5 * BIN_S:
            end_s = run.bins[0][0] + MEAN_S - 0.5 * BIN_S
            count = next(k for k, (t, _) in enumerate(run.bins) if t >= end_s)
            part, run.bins = np.array(run.bins[:count]), run.bins[count:]
            if len(part) < round(MEAN_S / BIN_S):
                continue  # some were lost: their mean belongs to another time
            mean_s, mean_mN = part.mean(axis=0)
            sigma_N = 1e-3 * sigma_mN / np.sqrt(len(part))
            run.estimator.add_force(run.drive, float(mean_s), 1e-3 * float(mean_mN), sigma_N)

    def _take_curve(self, run: FollowedRun, curve: Message) -> None:
        at_s = float(curve["time_s"]) - run.zero_s
        shape = run.motion.shape_at(at_s)
        if self._optics is None or shape is None:
            return
        distance_mm = None
        points_px = curve.get("points_px") or []
        if curve["ok"] and len(points_px) > 1:
            seen = self._optics.pixel_to_world(np.array(points_px, dtype=float))
            distance_mm = 1e3 * rms_distance(seen, shape)
            run.shape.add(at_s, distance_mm)
            if at_s >= run.curve_s + CURVE_EVERY_S:
                run.curve_s = at_s
                run.estimator.add_curve(run.drive, at_s, seen)
        run.drawn = {
            "frame": curve["frame"],
            "points_px": rounded_px(self._optics.world_to_pixel(shape)),
            "distance_mm": distance_mm,
        }

    # ------------------------------------------------------------------------------- what is said

    def _trace_estimate(self, run: FollowedRun) -> None:
        at_s = max(run.motion.time_s, 0.0)
        if at_s >= run.traced_s + TRACE_EVERY_S:
            run.traced_s = at_s
            self._trace.add(run.zero_s + at_s, self._configuration, run.estimator.estimate)

    def _message(self) -> Message:
        run = self._run
        if run is None:
            return {"type": MOTION, "state": "none", "why": self._why, "run": self._now}
        return {
            "type": MOTION,
            "state": "stopped" if run.stopped else "following",
            "why": "",
            "run": run.index,
            "run_s": round(max(run.motion.time_s, 0.0), 3),
            "over_s": OVER_S,
            "force_rms_mN": _rounded(run.force.rms),
            "force_mean_mN": _rounded(run.force.mean),
            "noise_mN": _rounded(white_noise(np.array(run.noise_mN)) if run.noise_mN else None),
            "shape_rms_mm": _rounded(run.shape.rms),
            "shape": run.drawn,
        }


def _middle(strip: StripChart, key: str) -> FloatArray:
    """Return the middle of a signal's least and most in each bin."""
    row = strip.names.index(f"{key}_least")
    return np.asarray(0.5 * (strip.values[row] + strip.values[row + 1]), dtype=float)


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 5)

"""The job `weighing`: `labrig calibrate load-cell`, one dead weight after the other."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from drivers.interfaces import RealClock
from drivers.load_cell import CalibrationError
from drivers.load_cell_fit import CalibrationFit, fit_calibration
from labrig.errors import BadInputError, ExitCode
from labrig.experiment.load_cell_calibration import weigh, write_calibration
from labrig.experiment.preflight import plan_of
from labrig.experiment.rig.wiring import wire
from labrig.panel.job.host import Host
from labrig.panel.job.operator import PageOperator
from labrig.panel.job.registry import hidden_folder
from labrig.panel.live.event_stream import Message
from labrig.panel.live.messages import MessageEncoder
from protocols.execution.events import Event
from protocols.execution.stop import StopLevel, StopRequest

MADE = "load_cell.made.toml"  # in the panel's own folder, until it is accepted
_LEAST_POINTS = 3


def weigh_all(host: Host) -> tuple[int, str]:
    """Ask for each weight, show the line as it grows, keep the calibration for acceptance."""
    if host.order.rig is None:
        raise BadInputError("a rig.toml is needed to weigh.")
    plan = plan_of(Path(host.order.rig))
    loads_N = [load / 1000 for load in host.order.loads_mN]
    encoder, stop = MessageEncoder(), StopRequest()
    operator = PageOperator(encoder, host.publish, stop, RealClock().now)
    host.on("answer", lambda asked: operator.answer(int(asked["prompt"]), bool(asked["done"])))
    host.on("stop", lambda asked: stop.request(StopLevel.NOW, str(asked.get("why", ""))))

    def show_simulated_operator(event: Event) -> None:
        """Show the prompts that the simulated operator answers."""
        message = encoder.message(event) if plan.rig.is_simulated else None
        if message is not None:
            host.publish(message)

    points = _Points(host, loads_N)
    rig = wire(plan, operator, show_simulated_operator)
    found = weigh(rig, plan, loads_N, lambda _text: None, points.add)
    points.publish(finished=True)
    made = hidden_folder(Path(host.order.data)) / MADE
    made.unlink(missing_ok=True)
    write_calibration(found.calibration, made)
    return ExitCode.DONE, "every weight was measured; check the line, then accept it"


class _Points:
    """What was weighed so far."""

    def __init__(self, host: Host, loads_N: Sequence[float]) -> None:
        self._host = host
        self._wanted_mN = [1e3 * load_N for load_N in loads_N]
        self._loads_N: list[float] = []
        self._volts: list[float] = []
        self.publish(finished=False)

    def add(self, load_N: float, mean_V: float) -> None:
        """One more."""
        self._loads_N.append(load_N)
        self._volts.append(mean_V)
        self.publish(finished=False)

    def publish(self, *, finished: bool) -> None:
        """Publish the points, and the line through them once there is one."""
        fit = self._fit()
        off_N = [None] * len(self._loads_N) if fit is None else list(fit.residuals_N)
        rows = zip(self._loads_N, self._volts, off_N, strict=True)
        self._host.publish(
            {
                "type": "weighing",
                "wanted": self._wanted_mN,
                "points": [
                    {
                        "load_mN": 1e3 * load_N,
                        "mV": 1e3 * volts,
                        "off_mN": None if off is None else 1e3 * float(off),
                    }
                    for load_N, volts, off in rows
                ],
                "fit": None if fit is None else _as_message(fit),
                "finished": finished,
            }
        )

    def _fit(self) -> CalibrationFit | None:
        if len(self._loads_N) < _LEAST_POINTS or len(set(self._loads_N)) < 2:
            return None
        try:
            return fit_calibration(self._loads_N, self._volts)
        except CalibrationError:
            return None  # the job ends with its sentence, when all weights are there


def _as_message(fit: CalibrationFit) -> Message:
    return {
        "sensitivity_V_per_N": fit.sensitivity_V_per_N,
        "sensitivity_sigma_V_per_N": fit.sensitivity_sigma_V_per_N,
        "offset_V": fit.offset_V,
        "offset_sigma_V": fit.offset_sigma_V,
    }

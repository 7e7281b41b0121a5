"""The job `run`: what `labrig run` does, with the page in the place of the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from labrig.config import RigConfig, load_rig
from labrig.config.hooks import HooksConfig
from labrig.errors import BadInputError, ExitCode, NotReadyError
from labrig.experiment.notices.hook_watch import hooks_of
from labrig.experiment.notices.hooks import Hooks, NotifyingOperator
from labrig.experiment.pause import PauseFile
from labrig.experiment.plan import Plan, load_plan
from labrig.experiment.resume import Resumption, resumed_plan
from labrig.experiment.rig.networked_rig import at_addresses, served_rig, why_not_served
from labrig.experiment.rig.rig import Rig
from labrig.experiment.rig.wiring import wire
from labrig.experiment.run import Result, run_session
from labrig.experiment.signals import stop_signals
from labrig.panel.job.follow import Follower
from labrig.panel.job.host import Host
from labrig.panel.job.operator import PageOperator
from labrig.panel.job.order import Order
from labrig.panel.job.preview import Preview
from labrig.panel.job.registry import hidden_folder
from labrig.panel.live.event_stream import Message
from labrig.panel.live.messages import MessageEncoder
from labrig.panel.live.optics_message import setup_message
from labrig.panel.live.plans import message_of_plan
from labrig.session import open_session
from protocols import ScheduleError
from protocols.execution.event_bus import EventBus, SubscriberError
from protocols.execution.events import ActionTaken
from protocols.execution.stop import StopLevel, StopRequest


def run(host: Host) -> tuple[int, str]:
    """Run the session; return the exit code and a sentence."""
    order = host.order
    if order.session is None:
        raise BadInputError("a run needs the name of the session file to make.")
    host.step("reading the files")
    with _planned(order) as (plan, resumption), _on_its_clock(host, plan) as rig_plan:
        done = resumption.done if resumption is not None else frozenset()
        clock = "virtual" if rig_plan.rig.is_simulated else "real"
        host.publish(setup_message(plan.optics, plan.sheets))
        planned = message_of_plan(plan, clock, order.session_name, done)
        host.publish(planned)
        host.step("starting the simulated rig" if rig_plan.rig.is_simulated else "loading drivers")
        config = _hooks_config(order, plan)
        path, is_guarded = Path(order.session), not rig_plan.rig.is_simulated
        with hooks_of(config, path, host.warn, is_guarded=is_guarded) as hooks:
            host.on_exit = hooks.close
            result = _Run(host, rig_plan, hooks, planned).execute(path, resumption)
            hooks.ended(completed=result.code == ExitCode.DONE, text=result.status.text)
    return int(result.code), f"{result.text}."


def _hooks_config(order: Order, plan: Plan) -> HooksConfig | None:
    """Return this rig's hooks; those of a session that is resumed may be anybody's."""
    if order.resume is None or order.rig is None:
        return plan.rig.hooks
    config = load_rig(Path(order.rig))
    return config.hooks if isinstance(config, RigConfig) else None


@contextmanager
def _planned(order: Order) -> Iterator[tuple[Plan, Resumption | None]]:
    if order.resume is None:
        plan = load_plan(*order.files())
        yield plan if order.about is None else plan.with_about(order.about), None
        return
    with open_session(Path(order.resume)) as session:
        resumption = Resumption(session)
        plan = resumed_plan(session)
        resumption.check(plan)
        yield plan, resumption


@contextmanager
def _on_its_clock(host: Host, plan: Plan) -> Iterator[Plan]:
    """Yield the plan on the simulated boards' own sockets, when it is to take its real time."""
    order = host.order
    if not plan.rig.is_simulated or order.clock == "virtual":
        yield plan
        return
    why_not = why_not_served(plan.schedule)
    if why_not:
        raise NotReadyError(why_not)
    rig = plan.rig
    options = ["--boards", rig.boards_kind]
    if rig.simulated is not None and rig.simulated.world is not None:
        options += ["--world", str(rig.simulated.world)]
    record = hidden_folder(Path(order.data)) / "world_record.csv"
    host.step("starting the simulated rig on the real clock")
    with served_rig(record, plan.schedule.runs[0].configuration, options) as served:
        yield replace(plan, rig=at_addresses(rig, served))


class _Run:
    """One run and the requests that it answers."""

    def __init__(self, host: Host, plan: Plan, hooks: Hooks, planned: Message) -> None:
        self._host = host
        self._plan = plan
        self._hooks = hooks
        self._planned = planned
        self._stop = StopRequest()
        self._pause: PauseFile | None = None  # once the session's file is named
        self._event_bus = EventBus(threaded=not plan.rig.is_simulated)
        encoder = MessageEncoder()
        asks_itself = not plan.rig.is_simulated
        self._follower = Follower(host.stream, encoder, asks_itself=asks_itself)
        self._operator = PageOperator(encoder, host.publish, self._stop, self._now)
        self._rig = self._wired(plan)
        for name, handler in (
            ("stop", self._do_stop),
            ("stop_after_pulse", self._do_stop_after_pulse),
            ("pause", self._do_pause),
            ("answer", self._do_answer),
            ("mark", self._do_mark),
            ("note", lambda asked: self._note(str(asked["who"]), str(asked["what"]))),
        ):
            host.on(name, handler)

    def execute(self, path: Path, resumption: Resumption | None) -> Result:
        """Run the session."""
        self._event_bus.add_best_effort("the panel", self._follower)
        self._pause = PauseFile(path)
        self._follower.on_begin = lambda: self._note(self._host.order.by, "started the run")
        with stop_signals(lambda name, _count: self._stop.request(StopLevel.NOW, f"got {name}")):
            result = run_session(
                self._rig,
                self._plan,
                path,
                self._stop,
                self._event_bus,
                resumption=resumption,
                on_step=self._host.step,
                on_simulated=self._tell_simulated,
                on_scheduler=lambda scheduler: setattr(self._follower, "scheduler", scheduler),
            )
        self._follower.publish_state()
        return result

    def _tell_simulated(self, simulated: bool) -> None:
        """Show of the rig what the file says of it."""
        if simulated != self._planned["simulated"]:
            self._host.publish({**self._planned, "simulated": simulated})

    def _wired(self, plan: Plan) -> Rig:
        operator = NotifyingOperator(self._operator, self._hooks)
        rig = wire(plan, operator, self._event_bus.emit)
        preview = None
        if rig.camera is not None and not plan.rig.is_simulated:
            preview = Preview(rig.camera, rig.clock, plan.schedule.frame_rate_hz)
            rig = replace(rig, camera=preview)
        self._follower.attach(rig, preview)
        return rig

    def _now(self) -> float:
        return self._rig.clock.now()

    # -------------------------------------------------------------------- requests of panels

    def _do_stop(self, asked: Message) -> None:
        who, why = str(asked.get("who", "somebody")), str(asked.get("why") or "")
        reason = f"STOP was pressed by {who}" + (f": {why}" if why else "")
        self._stop.request(StopLevel.NOW, reason)  # first of all; it waits for nothing
        self._note(who, f"pressed STOP{': ' + why if why else ''}")

    def _do_stop_after_pulse(self, asked: Message) -> None:
        who = str(asked["who"])
        self._stop.request(StopLevel.AFTER_PULSE, f"stopped by {who}, after the pulse")
        self._note(who, "asked for a stop after the pulse")

    def _do_pause(self, asked: Message) -> None:
        who, on = str(asked["who"]), bool(asked["on"])
        if self._pause is None or not self._follower.going:
            raise BadInputError("no session is going on, so none can pause.")
        if on:
            self._pause.ask(who)
        else:
            self._pause.end()
        self._host.publish({"type": "pause", "on": on, "who": who})
        self._note(who, "asked for a pause after this position" if on else "ended the pause")

    def _do_answer(self, asked: Message) -> None:
        answer = self._operator.answer(int(asked["prompt"]), bool(asked["done"]))
        self._note(str(asked["who"]), f"answered {answer}")

    def _do_mark(self, asked: Message) -> None:
        reading = asked["reading"]
        scheduler = self._follower.scheduler
        if scheduler is None:
            raise BadInputError("no run has begun yet, so nothing can be marked.")
        try:
            scheduler.mark(
                int(asked["run"]),
                None if reading is None else int(reading),
                str(asked["why"]),
                str(asked["who"]),
            )
        except ScheduleError as error:
            raise BadInputError(f"{error}.") from None
        except SubscriberError as error:
            raise BadInputError(f"it could not be recorded: {error}.") from None

    def _note(self, who: str, what: str) -> None:
        """Into the session's log, while there is one."""
        if self._follower.going:
            with suppress(SubscriberError):  # the run notices at its own next event
                self._event_bus.emit(ActionTaken(self._rig.clock.now(), who, what))

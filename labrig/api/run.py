"""`labrig.run`: the experiment."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from drivers.interfaces import Operator
from labrig.api.data import tell
from labrig.errors import BadInputError, ExitCode
from labrig.experiment.notices.hook_watch import hooks_of
from labrig.experiment.notices.hooks import Hooks, NotifyingOperator
from labrig.experiment.operator import NoOperator
from labrig.experiment.plan import Plan, load_plan
from labrig.experiment.preflight import calibrations, doubts, refuse_implausible
from labrig.experiment.resume import Resumption
from labrig.experiment.rig.rig import Step, no_step
from labrig.experiment.rig.wiring import wire
from labrig.experiment.run import Result, run_session
from labrig.experiment.signals import stop_signals
from labrig.files import AnyPath, check_session_name, path_of
from model.measurements.known_arguments import known_arguments
from protocols.execution.event_bus import EventBus
from protocols.execution.events import Event
from protocols.execution.stop import SignalledStop, StopRequest


@known_arguments
def run(
    rig: AnyPath,
    protocol: AnyPath,
    sheet: AnyPath,
    output: AnyPath,
    *,
    yes: bool = False,
    operator: Operator | None = None,
    about: AnyPath | None = None,
    on_event: Callable[[Event], None] | None = None,
    stop: StopRequest | None = None,
) -> Result:
    """Run an experiment and record it, as `labrig run` does.

    Args:
        rig: rig.toml. With `boards = "simulated"` there nothing real is touched.
        protocol: protocol.toml.
        sheet: sheet.toml.
        output: the session file to make; it must not be there yet.
        yes: answer the operator's questions with yes.
        operator: asked for moves and moistening: an object with `ask(prompt) -> bool`.
            One of `yes` and `operator` is needed where the rig is not simulated.
        about: about.toml; default: the one beside rig.toml, if any.
        on_event: called for each event of the session, in a thread of its own at a real rig. It
            must return at once; what it raises stops nothing.
        stop: a request to stop that another thread may make; see `protocols` `StopRequest`.

    Returns:
        Result: `path`, `outcome`, `code` (the command's exit code) and `text`. The output is at
        0 V and read back, or `text` says that it is not known to be safe.

    Raises:
        LabrigError, DeviceError: one sentence for a wrong file, a failed preflight or a device.

    In the main thread Ctrl-C (in a notebook: the stop button) once stops after the current pulse,
    twice at once. Warnings of the preflight are given as `LabrigWarning`.

    Example:
        >>> result = labrig.run(
        ...     "rig/rig.toml", "rig/protocol.toml", "rig/sheet.toml", "session.h5", yes=True
        ... )  # doctest: +SKIP
        >>> result.outcome.value  # doctest: +SKIP
        'completed'

    """
    plan = load_plan(
        path_of(rig), path_of(protocol), path_of(sheet), None if about is None else path_of(about)
    )
    if not (yes or operator is not None or plan.rig.is_simulated):
        raise BadInputError(
            "labrig.run: this rig is real: give operator=, or yes=True where all it asks for is "
            "done already."
        )
    path = path_of(output)
    check_session_name(path)
    asked = operator or NoOperator(lambda _prompt: None)  # the session records the prompts
    request = stop or StopRequest()
    hub = EventBus(threaded=not plan.rig.is_simulated)
    if on_event is not None:
        hub.add_best_effort("on_event", on_event)
    tell_of_doubts(plan, tell)
    with _stopping(request), session_hooks(plan, path, tell) as hooks:
        notified = asked if operator is None else NotifyingOperator(asked, hooks)
        return recorded(plan, path, notified, hub, request, hooks=hooks)


def tell_of_doubts(plan: Plan, say: Callable[[str], None]) -> None:
    """Say what is doubtful about a plan; raise LabrigError for what cannot be meant."""
    refuse_implausible(plan)
    for check in (*calibrations(plan), *doubts(plan)):
        if check.warning or not check.ok:
            say(f"warning: {check.in_words}")


@contextmanager
def session_hooks(plan: Plan, output: Path, say: Callable[[str], None]) -> Iterator[Hooks]:
    """Yield the rig's hooks; what is still told when the session is over is waited for."""
    hooks: Hooks | None = None
    try:
        is_guarded = not plan.rig.is_simulated
        with hooks_of(plan.rig.hooks, output, say, is_guarded=is_guarded) as hooks:
            yield hooks
    finally:
        if hooks is not None:
            hooks.close()


def recorded(
    plan: Plan,
    output: Path,
    operator: Operator,
    hub: EventBus,
    stop: StopRequest,
    *,
    hooks: Hooks,
    resumption: Resumption | None = None,
    step: Step = no_step,
) -> Result:
    """Run a plan on its rig, record it, and tell the hooks how it ended."""
    step("starting the simulated rig" if plan.rig.is_simulated else "loading drivers")
    rig = wire(plan, operator, hub.emit)
    result = run_session(rig, plan, output, stop, hub, resumption=resumption, on_step=step)
    hooks.ended(completed=result.code == ExitCode.DONE, text=result.status.text)
    return result


@contextmanager
def _stopping(stop: StopRequest) -> Iterator[None]:
    """Let Ctrl-C ask for a stop; a thread other than the main one gets no signals."""
    main = threading.current_thread() is threading.main_thread()
    with stop_signals(SignalledStop(stop)) if main else nullcontext():
        yield

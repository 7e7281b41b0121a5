"""The job `camera`: live pictures without a run, to aim and to calibrate."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from drivers.interfaces import Camera, Clock, DeviceError, RealClock
from labrig.errors import BadInputError, ExitCode, NotReadyError
from labrig.experiment.operator import NoOperator
from labrig.experiment.preflight import plan_of
from labrig.experiment.rig.rig import Rig
from labrig.experiment.rig.wiring import wire
from labrig.panel.job.host import Host
from labrig.panel.job.preview import Preview
from labrig.panel.live.frames import exposure_time, raw_picture


def show(host: Host) -> tuple[int, str]:
    """Show the camera's pictures until asked to end. Opens only the camera and its trigger."""
    if host.order.rig is None:
        raise BadInputError("a rig.toml is needed to show its camera.")
    plan = plan_of(Path(host.order.rig))
    rig = wire(plan, NoOperator(lambda _text: None))
    if rig.camera is None:
        raise BadInputError(f"{host.order.rig}: names no camera; add [camera].")
    ended = threading.Event()
    host.on("end", lambda _asked: ended.set())
    host.on("stop", lambda _asked: ended.set())
    with ExitStack() as devices:
        try:
            fire = _open(rig, rig.camera, devices)
            rig.camera.start()
        except DeviceError as fault:
            raise NotReadyError(str(fault)) from fault
        preview = Preview(rig.camera, rig.clock, plan.schedule.frame_rate_hz)
        _show_all(host, preview, rig.clock, ended, fire)
    return ExitCode.DONE, "the camera was closed"


def _open(rig: Rig, camera: Camera, devices: ExitStack) -> Callable[[], object]:
    """Open the camera, and what triggers it; return what triggers one frame."""
    camera.open()
    devices.callback(camera.close)
    if rig.trigger is None:
        return lambda: None
    devices.callback(rig.boards.close)
    rig.boards.open()
    devices.callback(rig.trigger.close)
    rig.trigger.open()
    return rig.trigger.fire


def _show_all(
    host: Host,
    camera: Preview,
    clock: Clock,
    ended: threading.Event,
    fire: Callable[[], object],
) -> None:
    begun_s, every_s = clock.now(), camera.every_s
    while not ended.is_set():
        fire()
        clock.sleep_until(clock.now() + every_s)
        if not isinstance(clock, RealClock):
            ended.wait(every_s)  # a virtual clock does not wait, an operator does
        camera.frames()
        frame = camera.newest()
        if frame is not None:
            exposed_s = exposure_time(clock, frame.time_s)
            picture = raw_picture(frame, frame.time_s - begun_s, None, None, exposed_s=exposed_s)
            host.stream.publish_picture(picture)

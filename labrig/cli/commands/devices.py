"""The cameras that can be found."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Json
from labrig.cli.screen import print_json, print_table, warn

_SIMULATED = {True: "yes", False: "no", None: "not known"}


def devices(as_json: Json = False) -> None:
    """List the cameras that can be found.

    Each is listed with its source for rig.toml. Cameras on the network, on USB 3 and behind GenTL
    producers are found; those of OpenCV and FireWire are not.
    """
    from drivers.cameras import CAMERAS
    from drivers.interfaces import DeviceError, DeviceIdentity

    found: list[tuple[str, DeviceIdentity]] = []
    failed: dict[str, str] = {}
    for kind, part in CAMERAS.parts().items():
        if part.part.find is None:
            continue
        try:
            found += [(kind, each) for each in part.part.find()]
        except DeviceError as fault:
            failed[kind] = str(fault)
    if as_json:
        cameras: list[dict[str, Any]] = [{"kind": kind, **asdict(each)} for kind, each in found]
        print_json({"cameras": cameras, "not_searched": failed})
        return
    rows = [
        [each.name, f"{each.maker} {each.product}", each.serial, each.driver,
         _SIMULATED[each.is_simulated]]
        for _, each in found
    ]  # fmt: skip
    print_table("Cameras", ["source", "product", "serial", "by", "simulated"], rows)
    for kind, why in failed.items():
        warn(f"no cameras of kind {kind} were looked for: {why}.")


COMMAND = Command(
    "devices",
    devices,
    order=35,
    examples=(CommandExample(line="labrig devices"),),
)

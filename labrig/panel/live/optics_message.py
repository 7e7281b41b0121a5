"""What a picture must be known with to find the sheet in it; between processes, not for pages."""

from __future__ import annotations

from collections.abc import Mapping

from labrig.panel.live.event_stream import Message
from labrig.vision import Optics, StripGeometry
from model.measurements import SheetGeometry


def setup_message(optics: Optics | None, sheets: Mapping[str, SheetGeometry]) -> Message:
    """Camera and strips, as JSON."""
    return {
        "type": "setup",
        "optics": None if optics is None else optics.model_dump(mode="json"),
        "strips": {
            name: {
                "free_length_m": sheet.free_length_m,
                "elongation_m": sheet.elongation_m,
                "thickness_m": sheet.thickness_m,
            }
            for name, sheet in sheets.items()
        },
    }


def optics_of(setup: Message) -> Optics | None:
    """Return the camera."""
    return None if setup.get("optics") is None else Optics.model_validate(setup["optics"])


def strips_of(setup: Message) -> dict[str, StripGeometry]:
    """Return the strips by configuration."""
    return {name: StripGeometry(**strip) for name, strip in setup.get("strips", {}).items()}

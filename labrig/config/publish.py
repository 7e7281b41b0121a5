"""`[publish]` of rig.toml: who is told what is measured while it is measured."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field

from labrig.config.base import ClosedModel


class PublishConfig(ClosedModel):
    """Documents of each session while it runs; a failure is logged and changes nothing else."""

    bluesky: Path = Field(
        description="file to which Bluesky documents are appended, one line of JSON each"
    )

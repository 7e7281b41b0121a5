"""`[hooks]` of rig.toml: who is told when a session waits, stops or is done."""

from __future__ import annotations

import os
from urllib.parse import urlsplit

from pydantic import Field, field_validator

from labrig.config.base import ClosedModel

FROM_ENVIRONMENT = "env:"


class HooksConfig(ClosedModel):
    """A command, a webhook, or both; a failure of theirs is logged and changes nothing else."""

    command: tuple[str, ...] = Field(
        (), description="program and arguments, no shell; {event}, {session}, {text} are filled in"
    )
    webhook: str | None = Field(
        None, description="http(s) address that is sent JSON by POST, or env:NAME of a variable"
    )
    timeout_s: float = Field(10.0, gt=0, le=60.0, description="then the hook is ended")
    waiting_after_s: float = Field(
        10.0, ge=0, le=86400.0, description="a question that stands for so long is reported"
    )

    @field_validator("webhook")
    @classmethod
    def _is_an_address(cls, webhook: str | None) -> str | None:
        if webhook is None or webhook.startswith(FROM_ENVIRONMENT):
            return webhook
        parts = urlsplit(webhook)
        if parts.scheme not in {"http", "https"} or not parts.hostname:
            raise ValueError("must begin with http:// or https://, or be env:NAME")
        return webhook

    @property
    def address(self) -> str | None:
        """The webhook's address; None: there is none, or its variable is not set."""
        if self.webhook is None or not self.webhook.startswith(FROM_ENVIRONMENT):
            return self.webhook
        return os.environ.get(self.webhook.removeprefix(FROM_ENVIRONMENT)) or None

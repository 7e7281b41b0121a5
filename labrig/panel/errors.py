"""What a request can be refused with: a sentence, and the status that goes with it."""

from __future__ import annotations

from labrig.errors import BadInputError, LabrigError, NotReadyError


class PanelError(LabrigError):
    """A request that is refused. `status` is that of the HTTP answer."""

    status = 400


class ForbiddenError(PanelError):
    """Somebody else holds control."""

    status = 403


class MissingError(PanelError):
    """There is no such thing."""

    status = 404


class NotNowError(PanelError):
    """Something else is going on."""

    status = 409


class UnreachableError(PanelError):
    """The job does not answer."""

    status = 503


def status_of(error: LabrigError) -> int:
    """Return the HTTP status of any of our errors."""
    if isinstance(error, PanelError):
        return error.status
    if isinstance(error, BadInputError):
        return 400
    return 409 if isinstance(error, NotReadyError) else 500

"""A page's connection, as far as uvicorn's own does not hold."""

from __future__ import annotations

from contextlib import suppress

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import InvalidState


class PageConnection(WebSocketsSansIOProtocol):
    """Ends with the panel, also in the middle of being closed by its page.

    uvicorn would say goodbye to such a page, which raises, and the panel would not be shut down in
    order. A page is in that state for long when it has not taken what was sent to it before.
    """

    def shutdown(self) -> None:
        """Close it with the panel."""
        with suppress(InvalidState):
            return super().shutdown()
        self.transport.close()
        return None

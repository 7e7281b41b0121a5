"""The panel's server ends quietly, whatever is still asked of it."""

from __future__ import annotations

import logging
import socket
import threading
import urllib.request
from contextlib import suppress

import pytest
import uvicorn
from fastapi import FastAPI

from labrig.panel.server.connection import PanelServer


@pytest.mark.slow
def test_what_is_still_asked_when_the_panel_ends_is_no_error(caplog, monkeypatch):
    errors = logging.getLogger("uvicorn.error")
    monkeypatch.setattr(errors, "level", errors.level)  # as it was, afterwards
    listening = socket.create_server(("127.0.0.1", 0))
    address = f"http://127.0.0.1:{listening.getsockname()[1]}/slow"
    asked, over = threading.Event(), threading.Event()
    app = FastAPI()

    @app.get("/slow")
    def slow() -> str:
        asked.set()
        over.wait(20.0)
        return "too late"

    config = uvicorn.Config(app, log_config=None, timeout_graceful_shutdown=1)
    server = PanelServer(config)
    serving = threading.Thread(target=server.run, args=([listening],))
    serving.start()
    page = threading.Thread(target=ask, args=(address,))
    page.start()
    assert asked.wait(10.0)
    caplog.clear()
    server.should_exit = True
    serving.join(10.0)
    over.set()
    page.join(10.0)
    assert not serving.is_alive()
    assert not [record for record in caplog.records if record.levelname == "ERROR"]


def ask(address: str) -> None:
    """Ask; the answer does not matter."""
    with suppress(OSError):
        urllib.request.urlopen(address, timeout=20.0).close()

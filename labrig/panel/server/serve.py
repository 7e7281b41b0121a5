"""Starts the panel: its socket, its STOP process, its server."""

from __future__ import annotations

import errno
import json
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import replace

from labrig.errors import BadInputError, LabrigError
from labrig.left_out import told_of
from labrig.panel.access.open_connections import LISTEN_BACKLOG, raise_descriptor_limit
from labrig.panel.access.rate_limits import UNIDENTIFIED, Buckets
from labrig.panel.access.settings import ANYWHERE, LOOPBACK, PanelSettings
from labrig.panel.core.sockets import MOST_MESSAGE_BYTES
from labrig.panel.processes import detached, module_environment

_MOST_CONNECTIONS = 1000  # those that have shown the token included
_GOODBYE_S = 2


def serve(settings: PanelSettings, on_ready: Callable[[PanelSettings], None]) -> None:
    """Serve until Ctrl-C. `on_ready` is called with the address as it came to be."""
    import uvicorn

    from labrig.panel.core.panel import Panel
    from labrig.panel.server.app import create_app
    from labrig.panel.server.connection import PageConnection, PanelServer, request_connections

    raise_descriptor_limit()
    with _bound(settings) as listening:
        settings = replace(settings, port=listening.getsockname()[1])
        # Before anything else is started: it finds the faults of files.
        with (
            closing(Panel(settings)) as panel,
            told_of(panel.tell_left_out),
            _stop_process(settings) as stop_port,
        ):
            panel.settings = replace(settings, stop_port=stop_port)
            unidentified = Buckets(*UNIDENTIFIED)
            config = uvicorn.Config(
                create_app(panel, unidentified),
                log_level="warning",
                access_log=False,
                server_header=False,
                http=request_connections(settings.token, unidentified),
                ws=PageConnection,
                backlog=LISTEN_BACKLOG,
                ws_max_size=2 * MOST_MESSAGE_BYTES,
                limit_concurrency=_MOST_CONNECTIONS,
                timeout_graceful_shutdown=_GOODBYE_S,
                ssl_certfile=settings.certificate,
                ssl_keyfile=settings.key,
            )
            on_ready(panel.settings)
            with suppress(KeyboardInterrupt):  # uvicorn hands it on when all is closed
                PanelServer(config).run(sockets=[listening])


_REMEDIES = {
    errno.EADDRINUSE: "another one may be there already: give another --port",
    errno.EACCES: "give another --port",  # one that is the system's own
}


@contextmanager
def _bound(settings: PanelSettings) -> Iterator[socket.socket]:
    family = socket.AF_INET6 if ":" in settings.host else socket.AF_INET
    try:
        address = (settings.host, settings.port)
        listening = socket.create_server(address, family=family, backlog=LISTEN_BACKLOG)
    except OSError as error:
        raise BadInputError(
            f"the panel cannot listen on {settings.host}:{settings.port} ({error.strerror}); "
            f"{_REMEDIES.get(error.errno or 0, 'check --host')}."
        ) from None
    with listening:
        yield listening


@contextmanager
def _stop_process(settings: PanelSettings) -> Iterator[int]:
    """Its port. When the panel ends, its input ends; it knows what to do then."""
    hosts = None if settings.host in ANYWHERE else [settings.host]
    wanted = {
        "host": settings.host,
        "port": settings.port + 1,
        "scheme": settings.scheme,
        "panel_port": settings.port,
        "hosts": sorted(LOOPBACK) if hosts and hosts[0] in LOOPBACK else hosts,
        "token": settings.token,
        "data": str(settings.data),
        "rig": None if settings.rig is None else str(settings.rig),
        "certificate": None if settings.certificate is None else str(settings.certificate),
        "key": None if settings.key is None else str(settings.key),
    }
    process = subprocess.Popen(
        [sys.executable, "-m", "labrig.panel.stop"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=module_environment(),
        **detached(),
    )
    assert process.stdin is not None  # noqa: S101 - for the type checker
    assert process.stdout is not None  # noqa: S101
    try:
        process.stdin.write(json.dumps(wanted).encode() + b"\n")
        process.stdin.flush()
        port = process.stdout.readline().strip()
        if not port.isdigit():
            raise LabrigError("the STOP process did not start; nothing is served without it.")
        yield int(port)
    finally:
        process.stdin.close()
        process.stdout.close()

"""The STOP process: a tiny HTTP server with an open connection to the job.

It outlives a panel that dies while a job is going on, for the pages that are still open. Standard
library only, so that it starts at once and has little that could fail.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from contextlib import suppress
from pathlib import Path

from labrig.panel.access.open_connections import raise_descriptor_limit
from labrig.panel.stop.press import StopConnection
from labrig.panel.stop.request import StopSettings
from labrig.panel.stop.server import StopServer

_POLL_S = 0.5


def main() -> None:
    """Serve until the panel has gone and no job is going on any more."""
    asked = sys.stdin.readline()
    if not asked:  # the panel has ended meanwhile
        return
    settings = StopSettings(**json.loads(asked))
    raise_descriptor_limit()
    line, ended = StopConnection(Path(settings.data), settings.rig), threading.Event()
    server = StopServer(settings, line)
    threading.Thread(target=line.watch, args=(ended,), name="line", daemon=True).start()
    server.start()
    with suppress(BrokenPipeError):  # likewise; what is buffered would be written once more
        os.write(sys.stdout.fileno(), f"{server.port}\n".encode())
    sys.stdin.read()  # ends with the panel
    while line.going:
        ended.wait(_POLL_S)


if __name__ == "__main__":
    main()

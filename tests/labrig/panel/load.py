"""Load on a server from this computer: silent connections, and a flood that knows no token.

`python -m tests.labrig.panel.load HOST:PORT PATH` floods until its input ends, and prints how often
each status was answered as JSON. A process of its own: it takes no time from who presses STOP.
"""

from __future__ import annotations

import json
import socket
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress

THREADS = 8
PATIENCE_S = 10.0


@contextmanager
def silent(netloc: str, count: int) -> Iterator[list[socket.socket]]:
    """Connections that say nothing."""
    with ExitStack() as stack:
        host, _, port = netloc.rpartition(":")
        yield [
            stack.enter_context(socket.create_connection((host, int(port)), PATIENCE_S))
            for _ in range(count)
        ]


@contextmanager
def flood(netloc: str, path: str) -> Iterator[Counter[str]]:
    """Requests without a token, as many as there can be; the statuses are known at the end."""
    found: Counter[str] = Counter()
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.labrig.panel.load", netloc, path],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        assert process.stdout.readline() == "refused\n", "the flood did not come about"
        yield found
    finally:
        told, _ = process.communicate("")
        found.update(json.loads(told))


def main() -> None:
    """Flood; the first line says that a request was refused as one too many."""
    netloc, path = sys.argv[1:]
    found: Counter[str] = Counter()
    ended, too_many = threading.Event(), threading.Event()
    request = f"POST {path} HTTP/1.1\r\nHost: {netloc}\r\nContent-Length: 0\r\n\r\n".encode()

    def ask() -> None:
        host, _, port = netloc.rpartition(":")
        while not ended.is_set():
            status = "none"
            with (
                suppress(OSError, IndexError),
                socket.create_connection((host, int(port)), PATIENCE_S) as one,
            ):
                one.sendall(request)
                status = one.recv(4096).split()[1].decode()
            found[status] += 1
            if status == "429":
                too_many.set()

    threads = [threading.Thread(target=ask) for _ in range(THREADS)]
    for thread in threads:
        thread.start()
    if too_many.wait(PATIENCE_S):
        print("refused", flush=True)
    sys.stdin.read()
    ended.set()
    for thread in threads:
        thread.join()
    print(json.dumps(found))


if __name__ == "__main__":
    main()

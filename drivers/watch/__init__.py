"""The watch: a process at the boards that writes 0 V when it no longer hears of the program."""

from drivers.watch.client import WatchLink
from drivers.watch.server import BoardsWatch
from drivers.watch.wire import PORT, read_token

__all__ = ["PORT", "BoardsWatch", "WatchLink", "read_token"]

"""The command line: one thin command per job."""

from labrig.cli.main import main

__all__ = ["main"]

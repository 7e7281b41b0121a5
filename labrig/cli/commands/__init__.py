"""The commands: a file each, which defines COMMAND (see `labrig.cli.command`)."""

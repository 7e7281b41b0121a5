"""Kinds of protocol, a file each: how a table of protocol.toml becomes steps and readings."""

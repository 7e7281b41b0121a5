"""A port that is not free."""


class PortTakenError(Exception):
    """Another program listens on the port."""

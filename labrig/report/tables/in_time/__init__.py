"""Tables of the sheet in time."""

"""Tables of the sheet in time: its parameters, and what further runs would tell of them."""

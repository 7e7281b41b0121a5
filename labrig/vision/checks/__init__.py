"""Check whether a fitted curve is the sheet. Each check is one file of `kinds`."""

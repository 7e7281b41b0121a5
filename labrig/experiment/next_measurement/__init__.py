"""The next measurement: its proposal, its protocol, and the loop that makes it."""

"""The measurement that is needed next: its protocol, the loop that makes it, what it must have."""

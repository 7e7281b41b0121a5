"""The measurement that a diagnosis asks for next: its protocol, and the loop that makes it."""

"""The verdict checks, one a file."""

"""The data checks, one a file."""

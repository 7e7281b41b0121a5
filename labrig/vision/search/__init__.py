"""Search an image for the path of the sheet."""

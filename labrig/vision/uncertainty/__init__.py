"""From a curve in pixels to a curve in metres with its uncertainty."""

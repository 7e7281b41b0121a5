"""Images: read, downscaled, with their noise."""

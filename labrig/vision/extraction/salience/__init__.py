"""A strip by what stands out in a photograph, as a network that was trained on many says."""

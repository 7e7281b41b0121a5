"""Components of the model that may be wrong, one file each, with their nonparametric terms."""

from model.locations.catalogue import location, locations, origins
from model.locations.contract import Location

__all__ = ["Location", "location", "locations", "origins"]

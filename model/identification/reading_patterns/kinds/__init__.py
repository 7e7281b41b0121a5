"""The patterns in readings that labrig knows: a file each, found by its `PATTERN`."""

"""Building blocks of a report: table, section, figure style."""

"""Tables for the command line and the report."""

"""The operator's page: a server that asks a run for what it shows, and never drives anything."""

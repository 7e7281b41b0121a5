"""A session, closed or under way, as documents of the Bluesky event model."""

"""Groups that are added to a closed session, and how the session takes them."""

"""The routes behind each page."""

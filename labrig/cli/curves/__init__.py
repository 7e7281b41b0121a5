"""What `labrig curves` does beside measuring images: sessions, options, comparisons."""

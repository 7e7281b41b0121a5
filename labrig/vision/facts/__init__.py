"""What somebody knows of a strip in a picture: one file for each kind of fact."""

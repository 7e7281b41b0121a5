"""The model that is written to a file: fitted parameters, inferred forms, and their uncertainty."""

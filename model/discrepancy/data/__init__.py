"""The data vector of a diagnosis: summary statistics, acquisition times, row index."""

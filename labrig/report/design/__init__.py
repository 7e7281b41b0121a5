"""Answers of `labrig design` as tables and figures."""

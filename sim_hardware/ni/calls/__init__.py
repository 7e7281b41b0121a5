"""Answers to the calls of NI's gRPC protocol."""

"""NI boards, local or behind a gRPC device server."""

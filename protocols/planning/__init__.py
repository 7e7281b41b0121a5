"""From a protocol to the schedule of a session, and its checks."""

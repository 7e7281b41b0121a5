"""One panel and what its pages have in common: control, the log of actions, sockets, requests."""

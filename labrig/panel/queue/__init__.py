"""The panel's queue: sessions that begin by themselves, one after the other."""

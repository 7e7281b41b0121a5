"""What runs in a process of its own: `python -m labrig.panel.job`, with an order on its input."""

from labrig.panel.job.order import Kind, Order

__all__ = ["Kind", "Order"]

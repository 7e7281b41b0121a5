"""The panel's web server: all routes put together, and the process that serves them."""

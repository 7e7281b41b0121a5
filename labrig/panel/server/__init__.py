"""The panel's web server: who may connect, and what each request is answered."""

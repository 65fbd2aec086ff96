"""Real-time ray tracing for Python."""

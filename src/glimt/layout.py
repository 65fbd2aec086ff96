"""Every struct and constant that two places share, declared once."""

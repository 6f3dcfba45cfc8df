"""What robots and worlds are written in."""

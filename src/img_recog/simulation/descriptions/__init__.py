"""Files of robots and worlds, read to plain values."""

"""Bodies in PyBullet: robots and the parts of a world."""

"""The master: whether it answers, and what it must know."""

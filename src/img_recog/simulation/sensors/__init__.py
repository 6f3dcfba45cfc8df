"""What a simulated robot measures."""

"""What there is to see of a simulation, and from where."""

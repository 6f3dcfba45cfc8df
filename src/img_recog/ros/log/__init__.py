"""Lines of the log: terminal, file and /rosout."""

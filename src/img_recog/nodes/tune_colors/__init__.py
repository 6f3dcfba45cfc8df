"""The tool tune_colors."""

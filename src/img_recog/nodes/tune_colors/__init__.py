"""The tool tune_colors: shows why a color is recognized in an image, or why not."""

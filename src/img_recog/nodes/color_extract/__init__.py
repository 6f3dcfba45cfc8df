"""The node color_extract."""

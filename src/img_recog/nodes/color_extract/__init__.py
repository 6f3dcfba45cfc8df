"""The node color_extract: commands the robot by the colors in images."""

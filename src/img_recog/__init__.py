"""Drive a robot by the colors a camera sees."""

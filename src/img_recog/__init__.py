"""Drive a robot by the colours a camera sees."""

"""Recordings: films, bags and pictures, by their names, as frames, whole or in parts."""

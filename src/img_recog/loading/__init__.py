"""Worlds and robots as users name them: found in packages, expanded by xacro, assembled."""

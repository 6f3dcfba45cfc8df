"""Readers of mesh files in all forms that Gazebo reads; `mesh_file` uses them."""

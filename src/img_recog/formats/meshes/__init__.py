"""Brings mesh files into forms that trimesh reads whole; `mesh_file` gives them to trimesh."""

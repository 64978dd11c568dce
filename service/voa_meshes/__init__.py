"""Mesh files (OBJ, STL, PLY, GLB) to vertices and faces: strict readers for files that nobody has checked."""

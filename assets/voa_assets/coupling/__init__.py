"""The coupling: mesh, scenario, physics, and the program that makes the mesh."""

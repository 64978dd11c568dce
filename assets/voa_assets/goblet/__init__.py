"""The goblet: mesh, scenario, physics, and the program that makes the mesh."""

"""The mug of the paper's evaluation: mesh, scenario, and the program that makes the mesh."""

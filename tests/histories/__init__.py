"""Tests of the checker of recorded calls: each fault planted in a recorded history is found, and no other."""

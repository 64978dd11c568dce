"""Zenoh in front of the use cases: queries and scans in, beliefs out.

Everything that a Zenoh thread calls returns at once: it hands over to a bounded queue, or refuses.
"""

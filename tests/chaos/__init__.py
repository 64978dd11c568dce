"""Attacks on a running service: what a stranger, a broken client or a failing machine can do to it.

`make chaos` runs all of them, on loopback alone and each bounded in time, and prints what was tried, the figure before
the attack was answered (as measured on the machine of that day), the figure now, its bound, and what survived.
"""

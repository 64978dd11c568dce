"""Groups of geometries: who is seen by the lidar, who touches whom, and how hard."""

WORLD_SEEN = 0
"""Table and clutter."""
ARM_SEEN = 1
OBJECT_SEEN = 2
"""The object's mesh: it meets rays and touches nothing."""
OBJECT_TOUCHED = 3
"""The object's solids: they touch and are not seen; rays would end on them before they reach the mesh."""
ROBOT = 4
"""The lidar robot: it does not see itself."""
TABLE_TOUCHED = 5
"""Solids of the object that touch the table alone."""

SEEN = (1, 1, 1, 0, 0, 0)
"""What rays meet, one flag per group."""
DRAWN = (1, 1, 1, 0, 1, 0)
"""What a camera shows."""

HAND_TABLE = 1
"""Bits of `contype` and `conaffinity`: two geometries touch if they share one."""
OBJECT_TABLE = 2
HAND_OBJECT = 4

STIFF = (0.004, 1.0)
"""`solref` of every contact: seconds, damping ratio. 5 ms steps would be too long for it."""
HARD = (0.95, 0.99, 0.001, 0.5, 2.0)
"""`solimp` of every contact: softer, and 40 N press the fingers millimetres into what they hold."""

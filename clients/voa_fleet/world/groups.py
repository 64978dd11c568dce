"""Groups of MuJoCo geometries: which of them the lidar sees, and which touch each other."""

WORLD_SEEN = 0
"""Table, floor and clutter."""
ARM_SEEN = 1
OBJECT_SEEN = 2
"""The object's mesh: the lidar's rays end on it, but it touches nothing."""
OBJECT_TOUCHED = 3
"""The object's solids: they touch, but rays pass through them, or they would end there before the mesh."""
ROBOT = 4
"""The lidar robot: its own lidar does not see it."""
TABLE_TOUCHED = 5
"""Solids of the object that touch nothing but the table."""

SEEN = (1, 1, 1, 0, 0, 0)
"""Flags of the groups on which the lidar's rays end, one per group."""
DRAWN = (1, 1, 1, 0, 1, 0)
"""Flags of the groups that a camera shows, one per group."""

HAND_TABLE = 1
"""Bits of `contype` and `conaffinity`: two geometries touch if they share one."""
OBJECT_TABLE = 2
HAND_OBJECT = 4

STIFF = (0.004, 1.0)
"""`solref` of every contact: seconds, damping ratio. It needs steps well below 5 ms."""
HARD = (0.95, 0.99, 0.001, 0.5, 2.0)
"""`solimp` of every contact: if it were softer, 40 N would press the fingers millimetres into the object."""

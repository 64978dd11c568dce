"""Grasps of a parallel gripper from an object's surface: proposed, chosen so that they cover the poses, and scored.

The method is that of antipodal grasps: two contacts hold an object if the line between them lies in the friction
cones of both.

| to                                                            | see          |
|---------------------------------------------------------------|--------------|
| propose a dozen grasps for an object's poses                  | `proposals`  |
| give every grasp and pose a first score from geometry         | `scoring`    |
| sample points and normals of a surface                        | `surface`    |
| place hands in the world, clear of the table                  | `hands`      |
| turn hands with an object at rest                             | `resting_hands` |
| group hands by what they hold and from where they come        | `kinds`      |
| make candidates from antipodal pairs of surface points        | `candidates` |
| close hands on the surface: collisions, contacts, widths      | `closing`    |
| move the object as the spread says, and count the good grips  | `shares`     |
| choose grasps that cover the poses and differ from each other | `cover`      |
| leave out grasps that the arm cannot reach                    | `reach`      |
| name grasps                                                   | `names`      |
"""

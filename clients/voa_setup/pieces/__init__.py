"""Convex pieces of a solid, which a physics engine can collide.

| to                                                     | see         |
|--------------------------------------------------------|-------------|
| turn meshes into solids and back                       | `solids`    |
| measure how far a solid is from convex, and where      | `notches`   |
| cut a closed solid into pieces that are nearly convex  | `cutting`   |
| join pieces that are nearly convex together            | `joining`   |
| make pieces of a surface that encloses no volume       | `shells`    |
"""

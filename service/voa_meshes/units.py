"""Which unit a mesh file was probably drawn in, told by the object's size."""

SMALL_M, LARGE_M = 3e-3, 3.0
"""Objects that an arm grasps are hardly smaller or larger."""
_UNITS = {"metres": 1.0, "millimetres": 1e-3, "centimetres": 1e-2}


def unit_hint(size_m: float, scale: float) -> str:
    """Say which `scale` would make an object that measures `size_m` at this one an object for an arm."""
    drawn = size_m / scale
    units = [f"{unit} (scale={metres:g})" for unit, metres in _UNITS.items() if SMALL_M <= drawn * metres <= LARGE_M]
    if not units:
        return "is `scale` right? It is metres per unit of the file"
    return f"is `scale` right? The file may be in {' or '.join(units)}"

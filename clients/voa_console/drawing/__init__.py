"""Scenes of `voa_scene` drawn in a page.

| to                                                              | see             |
|-----------------------------------------------------------------|-----------------|
| show a scene in a page, and what a person points at or drags    | `viewer`        |
| draw and change one shape                                       | `drawn_shapes`  |
| add copies of a mesh, lines and points to NiceGUI's objects     | `scene_objects` |
| compare two scenes, so that only changes are drawn              | `differences`   |
| give browsers the mesh of an object                             | `meshes`        |
"""

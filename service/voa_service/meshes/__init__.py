"""Reading untrusted mesh files: each in a process of its own, with limits on memory and time.

| file       | purpose                                                                         |
|------------|---------------------------------------------------------------------------------|
| `reader`   | starts the process for a file, checks the mesh, and explains why it was refused |
| `worker`   | the process itself: sets its limits, reads one file with `voa_meshes`           |
| `children` | child processes that are all killed when the service stops                      |
| `mistakes` | warnings about a mesh whose scale or up axis is probably wrong                  |
"""

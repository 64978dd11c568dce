"""Table of acceptance: whether promised values of looks come true, measured from outside in a world of its own.

Nothing of the service's mathematics is used: ray casting, noise and objects are written here, and requests go over HTTP
by `voa_client`. `python -m tests.acceptance` prints the table.

| module | contents |
|---|---|
| `casting` | cuts of meshes, and rays that meet them |
| `shapes` | meshes of the objects |
| `worlds` | objects near their listed poses, robots that err, lidars with noise |
| `scenes` | random objects and designed scenes |
| `rooms` | cluttered rooms |
| `customer` | the running service, its scenarios, updates and rankings |
| `values` | true values of looks, by fresh scans |
| `looks` | promised beside true values |
| `figures` | what was measured beside what is demanded |
| `sizes` | how much a run measures |
| `rows/` | the rows of the table |
"""

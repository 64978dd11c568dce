"""The mathematics of Value of Assistance for grasping: numpy in, numpy out; no I/O, no clock, no network.

| to                                            | see                                         |
|-----------------------------------------------|---------------------------------------------|
| describe object, poses, grasps                | `objects`, `poses`, `grasps`                |
| propose poses in which an object can rest     | `stable_poses`, `toppling`, `winding`       |
| describe the lidar and where it stands        | `lidars`, `workspace`                       |
| predict scans                                 | `prediction`, `cutting`, `rasterising`      |
| read measured scans                           | `scans`                                     |
| turn a scan into weights                      | `rules`, `evidence`                         |
| hold and update a belief                      | `filtering`, `updating`, `priors`           |
| value a look, rank looks                      | `weights`, `assistance`, `ranking`          |
| all of it for one object                      | `scenario`                                  |
"""

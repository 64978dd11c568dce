"""Make a scenario from a mesh: poses, grasps, grasp scores and places, and a page that shows whether they are right.

| to                                                           | see                |
|--------------------------------------------------------------|--------------------|
| make a whole scenario, step by step, from a person's choices | `setup`, `choices` |
| read a mesh in any unit, about its centre of mass            | `mesh`             |
| name the rests, and merge those that look the same           | `rests`            |
| make poses and their prior                                   | `poses`            |
| turn poses into rigid motions                                | `motions`          |
| compare a mesh with itself at another pose                   | `symmetry`         |
| make or read the places of the lidar                         | `places`           |
| choose the height of the scan plane                          | `heights`          |
| look up a gripper by its name or its opening                 | `grippers`         |
| propose grasps, and score them by geometry                   | `grasps/`          |
| divide a mesh into convex pieces for collisions              | `hulls`, `pieces/` |
| score grasps by simulated attempts, read and write scores    | `scores/`          |
| choose the source of the scores                              | `scoring`          |
| take the steps that need no grasps from a person's choices   | `steps`            |
| show rests, poses and the scan plane while a person chooses  | `previews/`        |
| write the files of a scenario                                | `writing`          |
| draw the page that shows whether it is right                 | `look/`            |
| estimate a robot's odometry origin or lidar mount            | `calibration/`     |
| catch what this package raises                               | `errors`           |
"""

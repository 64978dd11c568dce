"""A simulated fleet in MuJoCo, and the evaluations of the paper: a customer of the service like any other.

| to                                            | see                                     |
|-----------------------------------------------|-----------------------------------------|
| describe an object to look at and to grasp    | `objects`, `meshes`                     |
| build the world around it                     | `world`, `ur5e`, `gripper`, `lidar_robot`, `solids` |
| say how the world falls short of the ideal    | `imperfections`                         |
| move the arm, attempt grasps                  | `arm`, `attempts`                       |
| take scans                                    | `lidar`                                 |
| see how the object comes to rest              | `drops`                                 |
| drive a sensor robot or an arm, simulated or real | `devices`, `simulated`, `clocks`    |
| measure grasp scores, and prediction errors   | `grasp_scores`, `observation`           |
| make pictures                                 | `pictures`, `render`                    |

World frame: z up, the table at z = 0; metres, radians, seconds, newtons.
"""

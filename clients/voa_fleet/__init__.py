"""Simulated sensor robots and arms in MuJoCo, which know the service through its client alone.

| folder or file | contents                                                                                     |
|----------------|----------------------------------------------------------------------------------------------|
| `world/`       | table, objects, lidar, gripper and arm as one MuJoCo model; attempts of grasps; clocks       |
| `devices/`     | the protocols of a sensor robot and of an arm, simulated ones, and a skeleton of real ones   |
| `episodes/`    | one drop, the looks at it by a policy, one attempt of a grasp; the bench for drops           |
| `show/`        | what a person sees of it: lines and tables in a terminal, pictures, videos, HTML pages       |
| `errors`       | the errors that the fleet raises on purpose                                                  |
| `statistics`   | Wilson's interval of a probability that is estimated from successes of attempts              |

World frame: z up, the table at z = 0; metres, radians, seconds, newtons.
"""

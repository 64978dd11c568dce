"""The simulated world: table, objects, lidar, gripper and arm as one MuJoCo model.

| to                                            | see                                                 |
|-----------------------------------------------|-----------------------------------------------------|
| describe an object                            | `objects`, `shapes`, `meshes`                       |
| place it on the table                         | `object_poses`                                      |
| build the world around it                     | `scene`, `ur5e`, `gripper`, `lidar_robot`, `solids` |
| describe how the world differs from the ideal | `imperfections`                                     |
| compute the arm's motion, attempt a grasp     | `kinematics`, `attempts`                            |
| attempt many grasps at many poses             | `cells`                                             |
| measure ranges                                | `lidar`                                             |
| let time pass                                 | `clocks`                                            |

The other files serve these: `frames` for rotations, `groups` for which geometries the lidar sees and which touch.
"""

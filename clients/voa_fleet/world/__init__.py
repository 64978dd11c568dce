"""The simulated world: table, objects, lidar, gripper and arm as one MuJoCo model."""

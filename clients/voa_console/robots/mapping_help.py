"""Help for a laboratory without robots: the ways in which scans reach the service, with a mapping to start from."""

from nicegui import ui

from voa_console.robots.snippets import snippet

_MAPPING = """# robots.toml
[[robot]]
name = "tb3_1"
scenario = "THE ID OF YOUR SCENARIO"
lidar = { x = -0.032, y = 0.0, yaw_rad = 0.0 }
look = { mode = "stationary", scans = 10 }

[robot.place]
from = "odometry"
origin = { x = 0.4, y = 0.0, yaw_rad = 3.14159 }
std = { xy_m = 0.01, yaw_rad = 0.02 }"""
_SERVE = "voa serve --zenoh tcp/ROUTER:7447 --robots robots.toml"


def mapping_help() -> ui.card:
    """Draw the help."""
    with ui.card().classes("w-full gap-3").props('role="region" aria-label="No robots"') as card:
        ui.label("No robots yet").classes("text-lg font-medium").props('role="heading" aria-level="2"')
        ui.label(
            "No robot publishes scans on Zenoh to this service. Scans that programs send over HTTP are in the sessions."
        ).classes("text-sm")
        ui.label(
            "A ROS 2 robot with a stock driver needs one file that maps its topics; its scans come by "
            "zenoh-bridge-ros2dds or rmw_zenoh. Start the service with the router and this file, and the robot appears "
            "here:"
        ).classes("text-sm")
        snippet(_SERVE, "bash")
        snippet(_MAPPING, "toml")
        ui.label(
            "The five measures to take and every field are on the page “On your robots” of the documentation "
            "(deploy/docs/on-your-robots.md). A program of yours may instead publish scans on the Zenoh key "
            "scan/SESSION/ROBOT."
        ).classes("text-sm")
    return card

"""Make the scene of a session at one version from the facts that its viewer has."""

from voa_scene.ghosts import ghosts_of
from voa_scene.grasps import grasp_shapes
from voa_scene.measures import measures_of
from voa_scene.places import places_of
from voa_scene.robots import robot_shapes
from voa_scene.scans import scan_shapes
from voa_scene.shapes import AnyShape, Scene
from voa_scene.table import table_of
from voa_scene.views import SessionView


def scene_of(view: SessionView) -> Scene:
    """Make the scene of a session: table and workspace, ghosts of the object, towers of places, scan, robots, grasp.

    Equal views give equal scenes, and a shape keeps its group and name from version to version.
    """
    scenario = view.scenario
    measures = measures_of(scenario)
    shapes: list[AnyShape] = [
        *table_of(scenario, measures),
        *ghosts_of(scenario, view.belief),
        *places_of(scenario, view.ranking, measures),
    ]
    if view.scan is not None:
        shapes += scan_shapes(scenario, view.scan)
    for robot in view.robots:
        shapes += robot_shapes(robot, scenario.lidar.height_m or 0.0, measures)
    for grasp in scenario.grasps:
        if grasp.name == view.best_grasp:
            shapes += grasp_shapes(grasp)
    return Scene(tuple(shapes))

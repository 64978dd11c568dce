"""The types for which the service's own work compiles kernels beyond those of the warm-up, as a JSON list.

`python -m tests.deploy.main_job FOLDER`: in a process of its own, since other tests compile kernels for other types.
"""

import importlib
import json
import pkgutil
import sys
from pathlib import Path
from typing import Any

from numba.core.dispatcher import Dispatcher

import voa_core
from tests.support.serving import Service, box_obj, data_scenario, mesh_scenario, scan_of, serving
from voa_assets import path as asset_path
from voa_core import copies, evidence, scan_model
from voa_core.rules.registry import RULES
from voa_core.warmup import warm_up


def compiled() -> set[str]:
    """Each kernel of `voa_core` with each of the types for which it is compiled."""
    names = [module.name for module in pkgutil.walk_packages(voa_core.__path__, "voa_core.")]
    return {
        f"{name}.{attribute}{signature}"
        for name in names
        for attribute, value in vars(importlib.import_module(name)).items()
        if isinstance(value, Dispatcher)
        for signature in value.signatures
    }


def session(service: Service, body: dict[str, Any]) -> None:
    """Rank, look with and without uncertainty, and try a grasp, in a session on a scenario."""
    scenario = service.create(body)
    id_ = service.open(scenario)
    for definition in ("posterior", "executed"):
        service.get(f"/v1/sessions/{id_}/voa?definition={definition}&outcomes=true")
    predicted = service.post(f"/v1/scenarios/{scenario}/predictions", {})
    sensor, ranges = body["sensors"][0], predicted["ranges"][0][0]
    nothing = [beam for beam, value in enumerate(ranges) if value is None]
    service.post(f"/v1/sessions/{id_}/scans", scan_of(ranges, sensor["name"], no_return=nothing))
    if body.get("object"):
        place = {name: sensor[name] for name in ("x", "y", "yaw_rad")}
        for std in ({"xy_m": 0.005, "yaw_rad": 0.01}, {"xy_m": 0.05, "yaw_rad": 0.1}):
            request = {"sensor_pose": place | {"std": std}, "scan": {"ranges": ranges, "no_return": nothing}}
            service.post(f"/v1/sessions/{id_}/scans", request)
        service.get(f"/v1/scenarios/{scenario}/warnings")
    service.post(f"/v1/sessions/{id_}/grasp-outcomes", {"grasp": body["grasps"][0]["name"], "success": True})


def rank_after_a_look(service: Service, body: dict[str, Any]) -> None:
    """Rank over simulated scans before and after a look: alone, with a look under way, and at uncertain places."""
    scenario = service.create(body)
    id_ = service.open(scenario)
    predicted = service.post(f"/v1/scenarios/{scenario}/predictions", {})
    sensor, ranges = body["sensors"][0], predicted["ranges"][0][0]
    nothing = [beam for beam, value in enumerate(ranges) if value is None]
    for _ in range(2):
        service.get(f"/v1/sessions/{id_}/voa")
        service.post(f"/v1/sessions/{id_}/scans", scan_of(ranges, sensor["name"], no_return=nothing))
    place = {"x": sensor["x"] + 0.01, "y": sensor["y"], "yaw_rad": sensor["yaw_rad"]}
    for request in ({"pending": [sensor["name"]]}, {"sensors": [place], "sensor_std": {"xy_m": 0.01, "yaw_rad": 0.02}}):
        service.post(f"/v1/sessions/{id_}/voa", request)


def main(folder: Path) -> int:
    """Warm up, work, and print what was compiled by the work."""
    warm_up()
    before = compiled()
    # In several blocks, whose results are joined, as with many poses.
    evidence._NUMBERS_AT_ONCE, scan_model._COPIES_AT_ONCE, copies._PAIRS_AT_ONCE = 1, 1, 1
    mug = json.loads((asset_path("mug") / "scenario.json").read_text(encoding="utf-8"))
    for precision in ("float64", "float32"):
        with serving(folder / precision, precision=precision) as service:
            box = service.upload(box_obj())
            cup = service.upload((asset_path("mug") / "mug.obj").read_bytes(), "mug.obj")
            service.get(f"/v1/objects/{cup}/stable-poses")
            for rule in RULES:
                for body in (mesh_scenario(box), data_scenario(), mug | {"object": cup}):
                    session(service, body | {"update": {"rule": rule, "on_no_match": "nearest"}})
            for rule in (
                "beam",
                "margin",
            ):  # whose weights of displaced copies have kernels of their own, and which have not
                spread = {
                    "spread": {"xy_m": 0.005, "yaw_rad": 0.05},
                    "update": {"rule": rule, "on_no_match": "nearest"},
                }
                rank_after_a_look(service, mesh_scenario(box) | spread)
    print(json.dumps(sorted(compiled() - before)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main(Path(sys.argv[1])))

"""Overlays of kustomize, resolved as far as those of `deploy/kustomize` need it: no package index has kustomize itself.

A field that is not known here is an error, so that nothing which kustomize would do is left out.
"""

from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped] # the library has no types

Manifest = dict[str, Any]

_FIELDS = {"apiVersion", "kind", "namespace", "resources", "components", "patches", "labels", "configMapGenerator"}
_KEYS = {"containers": "name", "env": "name", "volumes": "name", "volumeMounts": "mountPath"}
"""Field that identifies the items of a list when a patch is merged; other lists are replaced."""


def resolve(folder: Path) -> list[Manifest]:
    """Return the manifests that `kubectl kustomize FOLDER` prints, but for digests in names.

    Raises:
        AssertionError: the folder uses a field, or a patch a target, that is not known.
    """
    return _applied(folder, [])


def _applied(folder: Path, manifests: list[Manifest]) -> list[Manifest]:
    """Return the manifests with those of a folder added and its changes made; for a component, of whoever names it."""
    content = yaml.safe_load((folder / "kustomization.yaml").read_text(encoding="utf-8"))
    assert set(content) <= _FIELDS, f"{folder}: {set(content) - _FIELDS}"
    for name in content.get("resources", []):
        path = folder / name
        manifests = manifests + (_applied(path, []) if path.is_dir() else _read(path))
    for name in content.get("components", []):
        manifests = _applied(folder / name, manifests)
    for each in content.get("configMapGenerator", []):
        manifests = _generated(manifests, each)
    for each in content.get("patches", []):
        assert set(each) == {"path"}, each
        for patch in _read(folder / each["path"]):
            manifests = _patched(manifests, patch)
    for each in content.get("labels", []):
        assert set(each) == {"pairs", "includeTemplates"}, each
        for manifest in manifests:
            _label(manifest, each["pairs"])
    if "namespace" in content:
        for manifest in manifests:
            manifest["metadata"]["namespace"] = content["namespace"]
    return manifests


def _read(path: Path) -> list[Manifest]:
    return list(yaml.safe_load_all(path.read_text(encoding="utf-8")))


def _generated(manifests: list[Manifest], generator: Manifest) -> list[Manifest]:
    assert set(generator) <= {"name", "behavior", "literals"}, generator
    data = dict(literal.split("=", 1) for literal in generator["literals"])
    made = {"apiVersion": "v1", "kind": "ConfigMap", "metadata": {"name": generator["name"]}, "data": data}
    if "behavior" not in generator:
        return [*manifests, made]
    assert generator["behavior"] == "merge"
    return _patched(manifests, made)


def _patched(manifests: list[Manifest], patch: Manifest) -> list[Manifest]:
    identity = _identity(patch)
    assert identity in map(_identity, manifests), f"nothing to patch: {identity}"
    return [_merged(each, patch) if _identity(each) == identity else each for each in manifests]


def _identity(manifest: Manifest) -> tuple[str, str, str]:
    return manifest["apiVersion"], manifest["kind"], manifest["metadata"]["name"]


def _merged(target: Manifest, patch: Manifest) -> Manifest:
    merged = dict(target)
    for field, value in patch.items():
        known = merged.get(field)
        if isinstance(value, dict) and isinstance(known, dict):
            merged[field] = _merged(known, value)
        elif isinstance(value, list) and isinstance(known, list) and field in _KEYS:
            merged[field] = _merged_items(known, value, _KEYS[field])
        else:
            merged[field] = value
    return merged


def _merged_items(targets: list[Manifest], patches: list[Manifest], key: str) -> list[Manifest]:
    changes = {patch[key]: patch for patch in patches}
    kept = [_merged(each, changes.pop(each[key], {})) for each in targets]
    return [*kept, *changes.values()]


def _label(manifest: Manifest, pairs: dict[str, str]) -> None:
    metadata = [manifest["metadata"]]
    if "template" in manifest.get("spec", {}):
        metadata.append(manifest["spec"]["template"]["metadata"])
    for each in metadata:
        each["labels"] = each.get("labels", {}) | pairs

"""The overlays of `deploy/kustomize` are what Kubernetes accepts, agree with the image, and run hardened."""

import re
from pathlib import Path
from typing import Any

import kubernetes_validate
import pytest

from tests.deploy.pages import page
from tests.deploy.variables import variables
from tests.support.kustomize import Manifest, resolve
from voa_service.settings import Settings

DEPLOY = Path(__file__).resolve().parents[2] / "deploy"
OVERLAYS = DEPLOY / "kustomize" / "overlays"
KUBERNETES = "1.33"
NAMES = sorted(folder.name for folder in OVERLAYS.iterdir())


def overlay(name: str) -> dict[tuple[str, str], Manifest]:
    return {(each["kind"], each["metadata"]["name"]): each for each in resolve(OVERLAYS / name)}


def pods(name: str) -> dict[str, dict[str, Any]]:
    """The specification of the pods of each deployment."""
    manifests = overlay(name)
    return {of: manifests[kind, of]["spec"]["template"]["spec"] for kind, of in manifests if kind == "Deployment"}


def container(name: str, of: str = "voa") -> dict[str, Any]:
    (only,) = pods(name)[of]["containers"]
    of_one: dict[str, Any] = only
    return of_one


@pytest.mark.parametrize("name", NAMES)
def test_kubernetes_accepts_every_manifest(name: str) -> None:
    manifests = resolve(OVERLAYS / name)
    for manifest in manifests:
        kubernetes_validate.validate(manifest, KUBERNETES, strict=True)
    assert len({(each["kind"], each["metadata"]["name"]) for each in manifests}) == len(manifests) > 9
    assert {each["metadata"]["namespace"] for each in manifests} == {"voa"}


def test_a_mistake_in_a_manifest_is_seen() -> None:
    manifest = overlay("lab")["Deployment", "voa"]
    manifest["spec"]["template"]["spec"]["containers"][0]["securityContext"]["readOnlyRootFilesystem"] = "yes"
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(manifest, KUBERNETES, strict=True)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("of", ["voa", "voa-console"])
def test_pods_run_hardened(name: str, of: str) -> None:
    pod = pods(name)[of]
    assert pod["securityContext"]["runAsNonRoot"] is True
    assert pod["securityContext"]["runAsUser"] == 10001
    assert pod["securityContext"]["seccompProfile"] == {"type": "RuntimeDefault"}
    assert pod["automountServiceAccountToken"] is False
    security = container(name, of)["securityContext"]
    assert security["readOnlyRootFilesystem"] is True
    assert security["allowPrivilegeEscalation"] is False
    assert security["capabilities"] == {"drop": ["ALL"]}
    assert not {"hostNetwork", "hostPID", "hostIPC"} & set(pod)


@pytest.mark.parametrize("name", NAMES)
def test_kubernetes_sets_no_variable_that_is_a_setting(name: str) -> None:
    services = [of for kind, of in overlay(name) if kind == "Service"]
    by_links = {f"{of.upper().replace('-', '_')}_PORT" for of in services}
    assert by_links & variables(Settings), "the links of a service named voa set VOA_PORT"
    assert all(pod["enableServiceLinks"] is False for pod in pods(name).values())


@pytest.mark.parametrize("name", NAMES)
def test_every_variable_is_a_setting(name: str) -> None:
    given = set(overlay(name)["ConfigMap", "voa-settings"]["data"])
    given |= {each["name"] for each in container(name).get("env", [])}
    assert given - {"PGPASSWORD"} - variables(Settings) == set()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("of", ["voa", "voa-console"])
def test_selectors_meet_the_pods_and_ports_exist(name: str, of: str) -> None:
    manifests = overlay(name)
    labels = manifests["Deployment", of]["spec"]["template"]["metadata"]["labels"]
    selector = {"app.kubernetes.io/name": of}
    assert selector.items() <= labels.items()
    assert manifests["Deployment", of]["spec"]["selector"]["matchLabels"] == selector
    assert manifests["Service", of]["spec"]["selector"] == selector
    assert manifests["NetworkPolicy", of]["spec"]["podSelector"]["matchLabels"] == selector
    everything = manifests["NetworkPolicy", "voa-nothing-else"]["spec"]
    assert everything["podSelector"]["matchLabels"].items() <= labels.items()
    assert "ingress" not in everything
    ports = {port["name"]: port["containerPort"] for port in container(name, of)["ports"]}
    (published,) = manifests["Service", of]["spec"]["ports"]
    assert ports[published["targetPort"]] == published["port"]
    dockerfile = (DEPLOY / "Dockerfile").read_text(encoding="utf-8")
    assert f"EXPOSE {published['port']}" in dockerfile


@pytest.mark.parametrize("name", NAMES)
def test_probes_are_the_services_own(name: str) -> None:
    only = container(name)
    assert only["livenessProbe"]["httpGet"]["path"] == only["startupProbe"]["httpGet"]["path"] == "/livez"
    assert only["readinessProbe"]["httpGet"]["path"] == "/readyz"
    pause = only["lifecycle"]["preStop"]["sleep"]["seconds"]
    given = overlay(name)["ConfigMap", "voa-settings"]["data"]
    stop = float(given.get("VOA_STOP_SECONDS", Settings.model_fields["stop_seconds"].default))
    assert pods(name)["voa"]["terminationGracePeriodSeconds"] > pause + stop


def test_sqlite_is_one_process_on_a_volume() -> None:
    manifests = overlay("sqlite")
    deployment = manifests["Deployment", "voa"]["spec"]
    assert (deployment["replicas"], deployment["strategy"]) == (1, {"type": "Recreate"})
    mounted = {each["mountPath"]: each["name"] for each in container("sqlite")["volumeMounts"]}
    claims = {each["name"]: each.get("persistentVolumeClaim") for each in pods("sqlite")["voa"]["volumes"]}
    claim = claims[mounted["/data"]]["claimName"]
    assert manifests["PersistentVolumeClaim", claim]["spec"]["accessModes"] == ["ReadWriteOnce"]
    assert "VOA_DATABASE_URL=sqlite:////data/" in (DEPLOY / "Dockerfile").read_text(encoding="utf-8")


def test_the_laboratory_has_replicas_that_take_turns() -> None:
    manifests = overlay("lab")
    deployment = manifests["Deployment", "voa"]["spec"]
    assert deployment["replicas"] >= 2
    assert deployment["strategy"]["rollingUpdate"]["maxUnavailable"] == 0
    budget = manifests["PodDisruptionBudget", "voa"]["spec"]
    assert budget["maxUnavailable"] < deployment["replicas"]
    assert budget["selector"]["matchLabels"] == deployment["selector"]["matchLabels"]
    assert not any(kind == "PersistentVolumeClaim" for kind, _ in manifests)


def test_secrets_stand_in_no_file_and_on_the_page_that_says_how_to_make_them() -> None:
    manifests = resolve(OVERLAYS / "lab")
    assert not [each for each in manifests if each["kind"] == "Secret"]
    wanted = {
        (each["valueFrom"]["secretKeyRef"]["name"], each["valueFrom"]["secretKeyRef"]["key"])
        for each in container("lab")["env"]
        if "valueFrom" in each
    }
    files = {
        Path(each).name for each in re.findall(r'"(/etc/voa/[^"]+)"', (DEPLOY / "zenoh/service.json5").read_text())
    }
    (mounted,) = [each["secret"]["secretName"] for each in pods("lab")["voa"]["volumes"] if "secret" in each]
    wanted |= {(mounted, file) for file in files | {"service.json5"}}
    text = page("deployment").text
    made = {
        (name, Path(re.split("=", entry)[0]).name)
        for name, arguments in re.findall(r"create secret generic (\S+)((?: \\\n +\S+| --\S+)+)", text)
        for entry in re.findall(r"--from-(?:literal|file)=(\S+)", arguments)
    }
    assert made == wanted

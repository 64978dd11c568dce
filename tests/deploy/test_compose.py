"""The compose files, the balancer and the Dockerfile agree with each other and with deploy/docs/operations.md.

These tests read the files that `make image` cannot run.
"""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped]

REPOSITORY = Path(__file__).resolve().parents[2]
DEPLOY = REPOSITORY / "deploy"
DOCKERFILE = (DEPLOY / "Dockerfile").read_text(encoding="utf-8")
FINAL_STAGE = DOCKERFILE.rpartition("\nFROM ")[2]
FILES = ["compose.yml", "compose.postgres.yml"]
OURS = [("compose.yml", "voa"), ("compose.postgres.yml", "voa-1"), ("compose.postgres.yml", "voa-2")]


def compose(file: str) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load((DEPLOY / file).read_text(encoding="utf-8"))
    return content


@pytest.mark.parametrize(("file", "service"), OURS)
def test_the_service_runs_hardened(file: str, service: str) -> None:
    entry = compose(file)["services"][service]
    assert entry["read_only"] is True
    assert entry["cap_drop"] == ["ALL"]
    assert entry["security_opt"] == ["no-new-privileges:true"]
    assert entry["tmpfs"] == ["/tmp"]  # noqa: S108 - in the container
    assert not {"privileged", "cap_add", "user", "network_mode", "pid"} & set(entry)


@pytest.mark.parametrize(("file", "service"), OURS)
def test_the_service_is_built_from_the_dockerfile_and_keeps_its_health_check(file: str, service: str) -> None:
    entry = compose(file)["services"][service]
    assert (DEPLOY / entry["build"]["context"]).resolve() == REPOSITORY
    assert (REPOSITORY / entry["build"]["dockerfile"]).is_file()
    assert {"interval", "timeout", "start_period", "retries"} == set(entry["healthcheck"])
    assert "/readyz" in FINAL_STAGE.partition("HEALTHCHECK")[2]


def test_the_build_stops_on_an_sqlite_that_can_lose_commits() -> None:
    assert "python -m voa_store.drivers" in DOCKERFILE


@pytest.mark.parametrize("file", FILES)
def test_only_this_machine_reaches_what_is_published(file: str) -> None:
    published = [port for service in compose(file)["services"].values() for port in service.get("ports", [])]
    assert published
    assert all(port.startswith("127.0.0.1:") for port in published)


@pytest.mark.parametrize("file", FILES)
def test_volumes_and_dependencies_exist(file: str) -> None:
    content = compose(file)
    for service in content["services"].values():
        for volume in service.get("volumes", []):
            source = volume.split(":")[0]
            assert (DEPLOY / source).is_file() if source.startswith("./") else source in content["volumes"]
        for other, how in service.get("depends_on", {}).items():
            assert how == {"condition": "service_healthy"}
            assert other in content["services"]
            assert "healthcheck" in content["services"][other]


def test_sqlite_is_one_replica_on_the_volume_that_the_image_names() -> None:
    (service,) = compose("compose.yml")["services"].values()
    assert service["volumes"] == ["data:/data"]
    assert "VOA_DATABASE_URL=sqlite:////data/voa.db" in FINAL_STAGE
    assert "VOLUME /data" in FINAL_STAGE


def test_replicas_share_a_database_and_have_nothing_of_their_own() -> None:
    services = compose("compose.postgres.yml")["services"]
    assert services["voa-1"] == services["voa-2"]
    assert "volumes" not in services["voa-1"]
    settings = services["voa-1"]["environment"]
    assert settings["VOA_DATABASE_URL"] == "postgresql+psycopg://voa@postgres/voa"
    assert settings["PGPASSWORD"] == services["postgres"]["environment"]["POSTGRES_PASSWORD"]
    assert settings["PGPASSWORD"].startswith("${POSTGRES_PASSWORD:?")
    major = re.match(r"postgres:(\d+)", services["postgres"]["image"])
    assert major is not None
    assert int(major[1]) >= 15


def test_the_balancer_checks_the_readiness_of_every_replica() -> None:
    services = compose("compose.postgres.yml")["services"]
    configuration = (DEPLOY / "haproxy.cfg").read_text(encoding="utf-8")
    behind = re.findall(r"^ *server (\S+) (\S+):8000$", configuration, flags=re.MULTILINE)
    assert behind == [(name, name) for name in services if name.startswith("voa-")]
    assert set(services["balancer"]["depends_on"]) == {name for name, _ in behind}
    assert "uri /readyz" in configuration


def test_clients_reach_the_balancer_by_https_alone() -> None:
    content = compose("compose.postgres.yml")
    balancer = content["services"]["balancer"]
    configuration = (DEPLOY / "haproxy.cfg").read_text(encoding="utf-8")
    frontends = re.split(r"^(?=frontend )", configuration.partition("\nbackend ")[0], flags=re.MULTILINE)[1:]
    secured, redirected = frontends
    assert {port.split(":", 1)[1] for port in balancer["ports"]} == {"8443:8443", "8000:8000"}
    assert re.search(r"^  bind :8443 ssl crt /run/secrets/voa\.pem\b", secured, flags=re.MULTILINE)
    assert "default_backend" not in redirected
    assert re.search(
        r"^  http-request redirect code 308 location https://.*:8443%\[capture\.req\.uri\]$", redirected, re.M
    )
    assert "ssl-min-ver TLSv1.2" in configuration


def test_the_balancer_gets_its_certificate_and_key_as_secrets_that_must_be_named() -> None:
    content = compose("compose.postgres.yml")
    mounted = {secret["source"]: secret["target"] for secret in content["services"]["balancer"]["secrets"]}
    assert mounted == {"certificate": "voa.pem", "private-key": "voa.pem.key"}  # haproxy reads the key beside it
    files = {name: secret["file"] for name, secret in content["secrets"].items()}
    assert set(files) == set(mounted)
    assert files["certificate"].startswith("${TLS_CERT:?")
    assert files["private-key"].startswith("${TLS_KEY:?")
    assert not any("secrets" in service for name, service in content["services"].items() if name != "balancer")


def test_the_image_has_an_unprivileged_user_version_and_license() -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "USER 10001:10001" in FINAL_STAGE
    assert f"ARG VERSION={project['version']}\n" in FINAL_STAGE
    assert f'org.opencontainers.image.licenses="{project["license"]}"' in FINAL_STAGE
    assert DOCKERFILE.count("FROM ${BASE_IMAGE}") == DOCKERFILE.count("FROM ") == 2


@pytest.mark.parametrize("name", ["requirements-service.lock", "requirements-build.lock"])
def test_the_image_gets_the_versions_that_the_tests_ran_with(name: str) -> None:
    def pins(path: Path) -> set[str]:
        return set(re.findall(r"^[a-z0-9.-]+==\S+", path.read_text(encoding="utf-8"), flags=re.MULTILINE))

    ours = pins(DEPLOY / name)
    assert ours
    assert ours <= pins(REPOSITORY / "requirements.lock")


@pytest.mark.parametrize("name", ["requirements-service.lock", "requirements-build.lock"])
def test_every_requirement_has_a_hash_and_none_an_address(name: str) -> None:
    content = (DEPLOY / name).read_text(encoding="utf-8")
    requirements = re.split(r"^(?=[a-z0-9])", content, flags=re.MULTILINE)[1:]
    assert all("--hash=sha256:" in requirement for requirement in requirements)
    assert "://" not in content

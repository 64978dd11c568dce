"""The compose files, the balancer and the Dockerfile agree with each other and with the settings.

These tests read the files that `make image` cannot run.
"""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped] # the library has no types

from tests.deploy.variables import variables
from voa_service.settings import Settings

REPOSITORY = Path(__file__).resolve().parents[2]
DEPLOY = REPOSITORY / "deploy"
DOCKERFILE = (DEPLOY / "Dockerfile").read_text(encoding="utf-8")
STAGES: dict[str, str] = {
    name: text for text, name in re.findall(r"(?ms)^(FROM \S+ AS (\w+)\n.*?)(?=^FROM |\Z)", DOCKERFILE)
}
FILES = ["compose.yml", "compose.lab.yml", "compose.monitoring.yml"]
SERVICES = [("compose.yml", "voa"), ("compose.lab.yml", "voa-1"), ("compose.lab.yml", "voa-2")]
OURS = [*SERVICES, ("compose.yml", "console"), ("compose.yml", "fleet"), ("compose.lab.yml", "console")]
LOCKS = [f"requirements-{name}.lock" for name in ("build", "core", "service", "fleet", "console")]


def compose(file: str) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load((DEPLOY / file).read_text(encoding="utf-8"))
    return content


def hardened() -> list[tuple[str, str]]:
    """Every container but the database's, which starts as root and gives that up."""
    return [(file, name) for file in FILES for name in compose(file)["services"] if name != "postgres"]


def stage(name: str) -> str:
    """The instructions of a stage of the Dockerfile, and those of the stages that it continues."""
    text = STAGES[name]
    before = text.split()[1]
    return (stage(before) if before in STAGES else "") + text


@pytest.mark.parametrize(("file", "service"), hardened())
def test_containers_run_hardened(file: str, service: str) -> None:
    entry = compose(file)["services"][service]
    assert entry["read_only"] is True
    assert entry["cap_drop"] == ["ALL"]
    assert entry["security_opt"] == ["no-new-privileges:true"]
    assert entry["tmpfs"] == ["/tmp"]  # noqa: S108 - in the container
    assert not {"privileged", "cap_add", "network_mode", "pid"} & set(entry)
    assert "mem_limit" in entry


@pytest.mark.parametrize(("file", "service"), OURS)
def test_our_images_are_built_from_the_dockerfile(file: str, service: str) -> None:
    entry = compose(file)["services"][service]
    target = entry["build"]["target"]
    assert (DEPLOY / entry["build"]["context"]).resolve() == REPOSITORY
    assert (REPOSITORY / entry["build"]["dockerfile"]).is_file()
    assert entry["image"] == {"service": "voa"}.get(target, f"voa-{target}")
    if entry["healthcheck"] != {"disable": True}:
        assert {"interval", "timeout", "start_period", "retries"} == set(entry["healthcheck"])
        assert "HEALTHCHECK" in STAGES[target]


@pytest.mark.parametrize(("file", "service"), SERVICES)
def test_replicas_are_checked_stopped_in_order_and_scraped(file: str, service: str) -> None:
    entry = compose(file)["services"][service]
    assert "/readyz" in STAGES["service"].partition("HEALTHCHECK")[2]
    stop = float(entry["environment"].get("VOA_STOP_SECONDS", Settings.model_fields["stop_seconds"].default))
    assert float(entry["stop_grace_period"].removesuffix("s")) > stop
    assert {name for name in entry["environment"] if name.startswith("VOA_")} <= variables(Settings)
    (job,) = yaml.safe_load((DEPLOY / "monitoring/prometheus.yml").read_text(encoding="utf-8"))["scrape_configs"]
    assert job["dns_sd_configs"][0]["names"] == entry["networks"]["default"]["aliases"]


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
            assert other in content["services"]
            if how != {"condition": "service_started"}:
                assert how == {"condition": "service_healthy"}
                assert "healthcheck" in content["services"][other]
        for secret in service.get("secrets", []):
            assert secret["source"] in content["secrets"]


def test_sqlite_is_one_replica_on_the_volume_that_the_image_names() -> None:
    assert compose("compose.yml")["services"]["voa"]["volumes"] == ["data:/data"]
    assert "VOA_DATABASE_URL=sqlite:////data/voa.db" in STAGES["service"]
    assert "VOLUME /data" in STAGES["service"]


def test_replicas_share_a_database_and_have_nothing_of_their_own() -> None:
    services = compose("compose.lab.yml")["services"]
    assert services["voa-1"] == services["voa-2"]
    assert all(volume.endswith(":ro") for volume in services["voa-1"]["volumes"])
    settings = services["voa-1"]["environment"]
    assert settings["VOA_REQUIRE_KEYS"] == "1"
    probes = re.search(r"inter (\d+)s fall (\d+)", (DEPLOY / "haproxy.cfg").read_text(encoding="utf-8"))
    assert probes is not None
    assert float(settings["VOA_DRAIN_SECONDS"]) > int(probes[1]) * int(probes[2])
    assert settings["VOA_DATABASE_URL"] == "postgresql+psycopg://voa@postgres/voa"
    assert settings["PGPASSWORD"] == services["postgres"]["environment"]["POSTGRES_PASSWORD"]
    assert settings["PGPASSWORD"].startswith("${POSTGRES_PASSWORD:?")
    major = re.match(r"postgres:(\d+)", services["postgres"]["image"])
    assert major is not None
    assert int(major[1]) >= 15


def test_the_balancer_checks_the_readiness_of_every_replica() -> None:
    services = compose("compose.lab.yml")["services"]
    configuration = (DEPLOY / "haproxy.cfg").read_text(encoding="utf-8")
    behind = re.findall(r"^ *server (\S+) (\S+):8000$", configuration, flags=re.MULTILINE)
    assert behind == [(name, name) for name in services if name.startswith("voa-")]
    assert set(services["balancer"]["depends_on"]) == {"console"} | {name for name, _ in behind}
    assert "uri /readyz" in configuration
    assert "  server console console:8080\n" in configuration


def test_clients_reach_the_balancer_by_https_alone() -> None:
    content = compose("compose.lab.yml")
    balancer = content["services"]["balancer"]
    configuration = (DEPLOY / "haproxy.cfg").read_text(encoding="utf-8")
    frontends = re.split(r"^(?=frontend )", configuration.partition("\nbackend ")[0], flags=re.MULTILINE)[1:]
    secured, console, redirected = frontends
    assert {port.split(":", 1)[1] for port in balancer["ports"]} == {"8443:8443", "8444:8444", "8000:8000"}
    assert re.search(r"^  bind :8444 ssl crt /run/secrets/voa\.pem\b", console, flags=re.MULTILINE)
    assert re.search(r"^  bind :8443 ssl crt /run/secrets/voa\.pem\b", secured, flags=re.MULTILINE)
    assert "default_backend" not in redirected
    assert re.search(
        r"^  http-request redirect code 308 location https://.*:8443%\[capture\.req\.uri\]$", redirected, re.M
    )
    assert "ssl-min-ver TLSv1.2" in configuration


def test_the_balancer_gets_its_certificate_and_key_as_secrets_that_must_be_named() -> None:
    content = compose("compose.lab.yml")
    mounted = {secret["source"]: secret["target"] for secret in content["services"]["balancer"]["secrets"]}
    assert mounted == {"certificate": "voa.pem", "private-key": "voa.pem.key"}  # haproxy reads the key beside it
    files = {name: secret["file"] for name, secret in content["secrets"].items()}
    assert set(mounted) < set(files)
    assert files["certificate"].startswith("${TLS_CERT:?")
    assert files["private-key"].startswith("${TLS_KEY:?")


def test_the_router_and_the_service_get_the_files_that_their_configurations_name() -> None:
    services = compose("compose.lab.yml")["services"]
    lab = (DEPLOY / "zenoh/lab.toml").read_text(encoding="utf-8")
    files = tomllib.loads(lab)["files"]
    named = {files[name] for name in ("ca", "certificate", "key")} | {services["router"]["command"][1]}
    assert {secret["target"] for secret in services["router"]["secrets"]} == named
    configuration = (DEPLOY / "zenoh/service.json5").read_text(encoding="utf-8")
    assert {secret["target"] for secret in services["voa-1"]["secrets"]} == set(re.findall(r'"(/.+?)"', configuration))
    (mounted,) = services["voa-1"]["volumes"]
    assert mounted == f"./zenoh/service.json5:{services['voa-1']['environment']['VOA_ZENOH__CONFIG']}:ro"


def test_the_example_has_every_variable_of_the_laboratory() -> None:
    texts = [(DEPLOY / file).read_text(encoding="utf-8") for file in ("compose.lab.yml", "compose.monitoring.yml")]
    wanted = set(re.findall(r"\$\{(\w+)", "".join(texts)))
    assert set(re.findall(r"(?m)^(\w+)=", (DEPLOY / "env.example").read_text(encoding="utf-8"))) == wanted


def test_grafana_reads_the_dashboard_and_queries_prometheus() -> None:
    services = compose("compose.monitoring.yml")["services"]
    grafana = dict(volume.split(":")[:2] for volume in services["grafana"]["volumes"])
    provisioning = DEPLOY / "monitoring/grafana"
    (provider,) = yaml.safe_load((provisioning / "dashboards.yml").read_text(encoding="utf-8"))["providers"]
    assert grafana["./monitoring/dashboard.json"].rpartition("/")[0] == provider["options"]["path"]
    (source,) = yaml.safe_load((provisioning / "datasources.yml").read_text(encoding="utf-8"))["datasources"]
    assert (source["type"], source["url"]) == ("prometheus", "http://prometheus:9090")
    prometheus = dict(volume.split(":")[:2] for volume in services["prometheus"]["volumes"])
    assert prometheus["./monitoring/rules.yml"] == "/etc/prometheus/rules.yml"
    (job,) = yaml.safe_load((DEPLOY / "monitoring/prometheus.yml").read_text(encoding="utf-8"))["scrape_configs"]
    (key,) = services["prometheus"]["secrets"]
    assert job["authorization"]["credentials_file"] == f"/run/secrets/{key['target']}"


@pytest.mark.parametrize("name", ["service", "console", "fleet"])
def test_images_have_an_unprivileged_user_version_and_license(name: str) -> None:
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    text = stage(name)
    assert re.findall(r"(?m)^USER (.*)", text)[-1] == "10001:10001"
    assert f"ARG VERSION={project['version']}\n" in text
    assert f'org.opencontainers.image.licenses="{project["license"]}"' in text
    assert f'title="{ {"service": "voa"}.get(name, "voa-" + name) }"' in text
    assert list(STAGES)[-1] == "service", "the one that a build without a target makes"


@pytest.mark.parametrize("name", LOCKS)
def test_the_image_gets_the_versions_that_the_tests_ran_with(name: str) -> None:
    def pins(path: Path) -> set[str]:
        return set(re.findall(r"^[a-z0-9.-]+==\S+", path.read_text(encoding="utf-8"), flags=re.MULTILINE))

    ours = pins(DEPLOY / name)
    assert ours
    assert ours <= pins(REPOSITORY / "requirements.lock")


@pytest.mark.parametrize("name", LOCKS)
def test_every_requirement_has_a_hash_and_none_an_address(name: str) -> None:
    content = (DEPLOY / name).read_text(encoding="utf-8")
    requirements = re.split(r"^(?=[a-z0-9])", content, flags=re.MULTILINE)[1:]
    assert all("--hash=sha256:" in requirement for requirement in requirements)
    assert "://" not in content

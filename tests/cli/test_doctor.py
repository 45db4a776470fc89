"""drone-cli doctor: what works here, and how to get the rest."""

from __future__ import annotations

import json
import sys
from importlib.metadata import version
from platform import python_version

import pytest

from tests.cli.run_cli import run_cli
from tests.hal.engines import ENGINES
from vencejo.version import __version__


def test_it_tells_what_is_here() -> None:
    result = run_cli("doctor")
    assert result.code == 0 and result.err == ""
    lines = {line.split()[0]: line for line in result.out.splitlines() if line.startswith("  ")}
    assert lines["vencejo"].endswith(__version__)
    assert lines["Python"].endswith(python_version())
    assert lines["numpy"].endswith(version("numpy"))
    assert lines["raster"].endswith("works")
    defaults = [name for name in ENGINES if lines[name].endswith(" (the default)")]
    assert defaults == list(ENGINES)[:1]
    assert result.out.splitlines()[-1].endswith("missions can fly here")


def test_json_has_the_same() -> None:
    result = run_cli("doctor", "--json")
    found = json.loads(result.out)
    assert result.code == 0 and found["can_fly"] is True
    assert found["engine"] == next(iter(ENGINES))
    for name in ENGINES:
        assert found["engines"][name]["works"] and found["engines"][name]["version"]
    assert found["renderers"]["raster"] == {"works": True, "version": "", "reason": "", "hint": ""}
    needed = {
        "click",
        "numpy",
        "opencv-python-headless",
        "pillow",
        "pymavlink",
        "pyyaml",
        "shapely",
    }
    assert {name.lower() for name in found["packages"]} == needed | {"rich", "transitions"}
    assert found["packages"]["click"] == version("click")


def test_what_is_missing_is_told_with_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pybullet", None)
    result = run_cli("doctor")
    assert 'pip install "vencejo[bullet]"' in result.out
    assert result.code == (0 if "mujoco" in ENGINES else 1)
    found = json.loads(run_cli("doctor", "--json").out)
    assert found["engine"] == "mujoco" and not found["engines"]["bullet"]["works"]
    assert not found["renderers"]["tiny"]["works"]
    assert "is pybullet's" in found["renderers"]["tiny"]["reason"]


def test_without_any_engine_nothing_flies(monkeypatch: pytest.MonkeyPatch) -> None:
    for package in ("pybullet", "mujoco"):
        monkeypatch.setitem(sys.modules, package, None)
    result = run_cli("doctor")
    assert result.code == 1
    assert 'pip install "vencejo[mujoco]"' in result.out
    assert result.out.splitlines()[-1].endswith("no mission can fly here")
    found = json.loads(run_cli("doctor", "--json").out)
    assert found["can_fly"] is False and found["renderers"]["raster"]["works"]


def test_a_missing_package_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cli.doctor.requires", lambda _: ["click>=8", "swifts-of-june>=1"])
    result = run_cli("doctor")
    assert result.code == 1 and 'pip install "swifts-of-june"' in result.out

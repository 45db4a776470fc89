"""The machine and the versions that figures were measured with."""

from __future__ import annotations

import os
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from platform import python_version

PACKAGES = ("vencejo", "pybullet", "mujoco-core", "transitions", "numpy", "PyYAML", "click")


def machine() -> str:
    """Describe processor, cores and versions in one line."""
    cpu = "unknown processor"
    info = Path("/proc/cpuinfo")
    if info.exists():
        models = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        cpu = models[0].partition(":")[2].strip() if models else cpu
    packages = ", ".join(filter(None, map(_installed, PACKAGES)))
    return f"{cpu}, {os.cpu_count()} cores; Python {python_version()}, {packages}"


def _installed(package: str) -> str:
    """The name and version of a package; empty for one that is not installed."""
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return ""

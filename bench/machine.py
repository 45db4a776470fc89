"""The machine and the versions that figures were measured with."""

from __future__ import annotations

import os
from importlib.metadata import version
from pathlib import Path
from platform import python_version

PACKAGES = ("vencejo", "pybullet", "transitions", "numpy", "PyYAML", "click")


def machine() -> str:
    """Describe processor, cores and versions in one line."""
    cpu = "unknown processor"
    info = Path("/proc/cpuinfo")
    if info.exists():
        models = [line for line in info.read_text().splitlines() if line.startswith("model name")]
        cpu = models[0].partition(":")[2].strip() if models else cpu
    packages = ", ".join(f"{package} {version(package)}" for package in PACKAGES)
    return f"{cpu}, {os.cpu_count()} cores; Python {python_version()}, {packages}"

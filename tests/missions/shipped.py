"""The shipped missions and fleets, by name."""

from __future__ import annotations

import re
from pathlib import Path

from runner.missions import SHIPPED


def _is_fleet(path: Path) -> bool:
    return re.search(r"^fleet:", path.read_text("utf-8"), re.MULTILINE) is not None


_PATHS = sorted(SHIPPED.glob("*.yaml"))
FLEETS = [path.stem for path in _PATHS if _is_fleet(path)]
MISSIONS = [path.stem for path in _PATHS if not _is_fleet(path)]

"""Missions by path or name: in ./missions first, then those that are shipped."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vencejo.errors import UserError, Where, nearest

_PACKAGE = Path(__file__).parent
_INSTALLED = _PACKAGE / "shipped" / "missions"
SHIPPED = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "missions"
"""Inside the package when installed from a wheel, beside it in a checkout."""


@dataclass(frozen=True)
class Found:
    """A mission's file, and the name that messages give it."""

    path: Path
    shown_as: str


def own_folder() -> Path:
    """The folder in which a person keeps missions that are run by name."""
    return Path("missions")


def names() -> dict[str, Path]:
    """All missions that can be run by name; one's own hide shipped ones."""
    found: dict[str, Path] = {}
    for folder in (SHIPPED, own_folder()):
        if folder.is_dir():
            found.update({path.stem: path for path in sorted(folder.glob("*.yaml"))})
    return found


def find(mission: str) -> Found:
    """The file of a mission given by path or name. Raises UserError."""
    path = Path(mission)
    there = _exists(path)
    if there or "/" in mission or path.suffix in (".yaml", ".yml", ".scxml"):
        if not there:
            near = (
                [str(other) for other in path.parent.glob("*.y*ml")] if path.parent.is_dir() else []
            )
            hint = nearest(mission, [*near, *names()], "`drone-cli missions` lists those there are")
            raise UserError("no-such-file", f"there is no file '{mission}'", Where(mission), hint)
        return Found(path, mission)
    known = names()
    if mission not in known:
        raise UserError(
            "unknown-mission",
            f"there is no mission '{mission}', neither a file nor in ./missions nor shipped",
            hint=nearest(mission, known, "`drone-cli missions` lists those there are"),
        )
    return Found(known[mission], _short(known[mission]))


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except OSError:
        return False  # too long a name, which nothing can have


def _short(path: Path) -> str:
    try:
        return str(path.relative_to(Path.cwd()))
    except (ValueError, OSError):
        return str(path)  # elsewhere, or the working directory is gone

"""Missions by path or name: in ./missions first, then those that are shipped."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vencejo.errors import UserError, Where, nearest
from vencejo.files import nearest_file

_PACKAGE = Path(__file__).parent
_INSTALLED = _PACKAGE / "shipped" / "missions"
SHIPPED = _INSTALLED if _INSTALLED.is_dir() else _PACKAGE.parent / "missions"
"""Inside the package when installed from a wheel, beside it in a checkout."""


_NO_MISSIONS = (".py", ".md", ".csv", ".jsonl", ".png", ".jpg", ".svg")
"""Endings of what lies beside missions and is none."""


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
            listed = "`drone-cli missions` lists those there are"
            hint = nearest_file(mission, [*near, *names()], listed)
            raise UserError("no-such-file", f"there is no file '{mission}'", Where(mission), hint)
        if path.suffix in _NO_MISSIONS:
            raise UserError(
                "not-a-mission",
                f"'{mission}' is no mission: those are .yaml or .scxml files",
                Where(mission),
                "a mission names Python under `uses`" if path.suffix == ".py" else None,
            )
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

"""The files that a flight depends on, as its run folder keeps them.

What a person wrote keeps its place beside what names it, so that the copies can be flown too.
"""

from __future__ import annotations

import os.path
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from itertools import count
from pathlib import Path, PurePosixPath

from runner.plan import Plan
from runner.preparation import Prepared
from runner.run_folder import OWN_NAMES
from vencejo.files import is_file_word
from worlds import World

_ELSEWHERE = "elsewhere"
"""Folder of the files that are named by an absolute path: nothing finds them by their place."""


@dataclass(frozen=True)
class KeptFiles:
    """Copies of files, by their path in a run folder."""

    contents: Mapping[str, bytes]
    missions: Mapping[str, str]
    """Vehicle → its mission's own file; nothing for one without a mission."""
    world: str
    camera_file: str | None
    fleet: str = ""
    """The fleet's own file; empty for none."""
    models: Mapping[str, str] = field(default_factory=dict)
    """Path of a model that a vehicle was given → its copy."""

    def hashes(self) -> dict[str, str]:
        """SHA-256 of each, hexadecimal."""
        return {name: file_hash(content) for name, content in self.contents.items()}


def file_hash(content: bytes) -> str:
    """SHA-256 of a file's content, hexadecimal."""
    return sha256(content).hexdigest()


def kept_files(plan: Plan) -> KeptFiles:
    """The copies of a plan's missions, their code, the world, the camera file and models.

    Missions, and what they include and use, come first; what has a name that is taken goes into a
    folder of its own, with all that it names.
    """
    contents: dict[str, bytes] = {}
    flown = {name: each.prepared for name, each in plan.assignments.items() if not each.stands}
    fleet = plan.fleet.file if plan.fleet else None
    if fleet is None:
        kept, missions = "", _keep_missions(flown, contents)
    else:
        kept, missions = _keep_fleet(fleet.resolve(), flown, contents)
    world = _add(contents, _world_copies(plan.world), "world")
    camera_file = None
    if plan.camera_file is not None:
        copies = _copies([plan.camera_file], plan.camera_file.parent)
        camera_file = _add(contents, copies, "cameras")
    models = {}
    for each in plan.assignments.values():
        if each.model and is_file_word(each.model) and each.model not in models:
            path = Path(each.model)
            models[each.model] = _add(contents, _copies([path], path.parent), "models")
    return KeptFiles(contents, missions, world, camera_file, kept, models)


def _keep_missions(flown: Mapping[str, Prepared], contents: dict[str, bytes]) -> dict[str, str]:
    """Add the files of missions to ``contents``; each vehicle's mission among them."""
    missions: dict[str, str] = {}
    files: dict[tuple[Path, ...], str] = {}
    for vehicle, prepared in flown.items():
        if prepared.files not in files:
            copies = _copies(prepared.files, prepared.found.path.parent)
            files[prepared.files] = _add(contents, copies, vehicle)
        missions[vehicle] = files[prepared.files]
    return missions


def _keep_fleet(
    fleet: Path, flown: Mapping[str, Prepared], contents: dict[str, bytes]
) -> tuple[str, dict[str, str]]:
    """Add a fleet's file, and the missions that lie beside it, at their places about each other;
    the fleet's file, and each vehicle's mission among them.
    """
    own = [file.resolve() for prepared in flown.values() for file in prepared.files]
    paths = list(dict.fromkeys((fleet, *own)))
    copies = _copies(paths, fleet.parent)
    first = _add(contents, copies, "fleet")
    prefix = first.removesuffix(next(iter(copies)))
    kept = {path: prefix + name for path, name in zip(paths, copies, strict=True)}
    return first, {vehicle: kept[each.files[0].resolve()] for vehicle, each in flown.items()}


def _world_copies(world: World) -> dict[str, bytes]:
    """The copies of a world and the files it names; a generated one is written down."""
    if not world.files:
        return {f"{world.name}.yaml": world.text.encode()}
    return _copies(world.files, world.source.parent)


def _copies(files: Iterable[Path], folder: Path) -> dict[str, bytes]:
    """The contents of files by their place about ``folder``, from which they are named.

    Where one lies outside (``../pictures/grass.png``), all lie deeper by as many folders.
    """
    beside = {path: os.path.relpath(path, folder) for path in files if path.is_relative_to(folder)}
    ups = [PurePosixPath(Path(place).as_posix()).parts.count("..") for place in beside.values()]
    base = Path(os.path.normpath(folder.absolute()))
    for _ in range(max(ups, default=0)):
        base = base.parent
    found: dict[str, bytes] = {}
    for number, path in enumerate(files):
        place = f"{_ELSEWHERE}/{number}-{path.name}"
        if path in beside:
            place = Path(os.path.relpath(path, base)).as_posix()
        found[place] = path.read_bytes()
    return found


def _add(contents: dict[str, bytes], copies: Mapping[str, bytes], aside: str) -> str:
    """Add copies, if need be in a folder called ``aside``; the path of the first of them."""
    is_free = _free(contents)
    prefixes = ("" if n == 0 else f"{aside}/" if n == 1 else f"{aside}-{n}/" for n in count())
    prefix = next(each for each in prefixes if all(is_free(each + name) for name in copies))
    contents.update({prefix + name: content for name, content in copies.items()})
    return prefix + next(iter(copies))


def _free(contents: Collection[str]) -> Callable[[str], bool]:
    """Whether a path is neither taken, nor in a file, nor a folder of others."""
    taken = [PurePosixPath(name) for name in (*contents, *OWN_NAMES)]

    def is_free(name: str) -> bool:
        path = PurePosixPath(name)
        return not any(path.is_relative_to(each) or each.is_relative_to(path) for each in taken)

    return is_free

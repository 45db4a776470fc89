"""Reads world files. All faults of a file are reported at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType
from typing import Any

from vencejo import nodes
from vencejo.errors import Fault, UserError, Where
from vencejo.files import named_from
from vencejo.geometry import Point
from vencejo.nodes import Scalar, YamlNode, read_file, read_text
from worlds import roads
from worlds.environment import GROUND, LIGHT, ORIGIN, STARTS
from worlds.fence import FENCE
from worlds.kinds import BEACON, KINDS
from worlds.starts import PlannedStart, bad_starts, overlapping, starts_outside
from worlds.terrain import place_of
from worlds.values import PLACE, SHARE, TEXT, Field, NamedEntries, Spot, names, read_fields
from worlds.wind import WIND
from worlds.world import Start, World

FIELDS: Mapping[str, Field] = MappingProxyType(
    {
        "world": Field(TEXT),
        "description": Field(TEXT, ""),
        "origin": Field(ORIGIN, None),
        "ground": GROUND,
        "light": LIGHT,
        "wind": Field(WIND, None),
        "start": Field(STARTS, None),
        "battery": Field(SHARE, 1.0),
        "model": Field(TEXT, None),
        "fence": Field(FENCE, None),
        "roads": Field(names("roads", roads.ROAD), NamedEntries()),
        **{kind: Field(names(kind, value), NamedEntries()) for kind, value in KINDS.items()},
        "beacons": Field(names("beacons", BEACON), NamedEntries()),
        "places": Field(names("places", PLACE), NamedEntries()),
    }
)
"""The keys of a world file."""
NAMED = ("roads", *KINDS, "beacons", "places")


def load_world(path: Path) -> World:
    """The world in a file. Raises UserError with every fault of the file."""
    root = read_file(path)
    files = tuple(dict.fromkeys((path, *_files(root))))
    return _world(root, path, path.read_text("utf-8-sig"), files)


def read_world(text: str, name: str) -> World:
    """The world in a text; ``name`` stands for its path. Raises UserError with every fault."""
    return _world(read_text(text, name), Path(name), text, ())


def _files(node: YamlNode) -> Iterator[Path]:
    """The images, meshes and models that a world file names and that exist."""
    if isinstance(node, nodes.Sequence):
        for item in node.items:
            yield from _files(item)
    elif isinstance(node, nodes.Mapping):
        for key, value in node:
            if isinstance(value, Scalar) and key.text in ("texture", "file", "model"):
                path = Path(value.where.file).parent / value.text
                if path.is_file():
                    yield path
                    yield from _meshes(path)
            else:
                yield from _files(value)


def _meshes(path: Path) -> tuple[Path, ...]:
    """The meshes that a model's file names; none of images, of meshes and of YAML."""
    if path.suffix.lower() in (".obj", ".stl", ".png", ".jpg", ".jpeg", ".yaml", ".yml"):
        return ()
    from worlds.model_files import mesh_files_of  # late: it needs numpy

    return mesh_files_of(path)


def _world(root: nodes.Mapping, source: Path, text: str, files: tuple[Path, ...]) -> World:
    keys, faults = read_fields(root, "a world", FIELDS)
    named = {key: keys.get(key, NamedEntries()) for key in NAMED}
    for key in NAMED:
        faults.extend(named[key].faults)
    faults.extend(_repeated(named))
    ground = keys.get("ground", GROUND.default)
    terrain = ground.terrain
    things = tuple(
        draft.thing(key.text, terrain)
        for kind in (*KINDS, "beacons")
        for key, draft in named[kind].entries
    )
    written = (
        keys.get("start") or [(root.where, Spot(0.0, 0.0), 0.0, None)] if "start" in keys else []
    )
    starts = [
        PlannedStart(Start(place_of(terrain, spot), heading, color), where)
        for where, spot, heading, color in written
    ]
    faults.extend(bad_starts(starts, things, terrain))
    faults.extend(overlapping(starts))
    faults.extend(starts_outside(starts, keys.get("fence")))
    if faults:
        raise UserError.of(sorted(faults, key=lambda fault: fault.where or root.where))
    beacons = {thing.name: thing.at for thing in things if thing.kind == "beacon"}
    places = {key.text: Point(*place) for key, place in named["places"].entries}
    return World(
        name=keys["world"],
        description=keys["description"],
        origin=keys["origin"],
        ground=replace(
            ground, stripes=roads.stripes_of(road for _, road in named["roads"].entries)
        ),
        starts=tuple(planned.start for planned in starts),
        battery=keys["battery"],
        model=keys["model"] and named_from(source.parent, keys["model"]),
        places=MappingProxyType(beacons | places),
        source=source,
        sha256=_digest([file.read_bytes() for file in files] or [text.encode()]),
        things=things,
        light=keys["light"],
        wind=keys["wind"],
        fence=keys["fence"],
        roads=tuple(road.road(key.text) for key, road in named["roads"].entries),
        text=text,
        files=files,
    )


def _digest(contents: list[bytes]) -> str:
    """The SHA-256 of the contents, one after the other."""
    return sha256(b"".join(contents)).hexdigest()


def _repeated(named: Mapping[str, NamedEntries[Any]]) -> Iterator[Fault]:
    """Faults for names that stand for two things, and for places that are beacons already."""
    first: dict[str, tuple[str, Where]] = {}
    keys = [(key, kind) for kind in NAMED for key, _ in named[kind].entries if kind != "places"]
    for key, kind in sorted(keys, key=lambda item: item[0].where):
        if key.text in first:
            other, where = first[key.text]
            yield Fault(
                "duplicate-name",
                f"'{key.text}' stands under '{other}' already, in line {where.line}",
                key.where,
                "rename one of the two: each thing and road has a name of its own",
            )
        first.setdefault(key.text, (kind, key.where))
    for key, _ in named["places"].entries:
        if first.get(key.text, ("", None))[0] == "beacons":
            yield Fault(
                "duplicate-name",
                f"'{key.text}' is a beacon already, and beacons are places",
                key.where,
                "rename one of the two",
            )

"""The JSON Schema of world files, for editors and for programs that write them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from worlds.loader import FIELDS
from worlds.values import fields_schema

HELP: Mapping[str, str] = {
    "alt": "Metres above mean sea level.",
    "ambient": "How bright the shade is, 0 to 100 %.",
    "at": "Where it stands, the middle of its underside: [x, y] or [x, y, z], metres; of gusts, "
    "the times at which they reach the world's origin.",
    "battery": "Charge of every vehicle when the run begins.",
    "beacons": "Coloured balls that are no obstacles; each is a place too.",
    "boards": "ChArUco boards.",
    "boxes": "Solid cuboids.",
    "cars": "Cars, 4.2 m long.",
    "charges": "Power for the battery of a vehicle that stands on it with its motors off.",
    "color": "A name, or [red, green, blue] from 0 to 255.",
    "ceiling": "Greatest height to fly at, metres.",
    "columns": "Squares along its width.",
    "crossing": "Whether the road may meet itself.",
    "cylinders": "Upright poles and tanks.",
    "description": "One sentence that says what it is.",
    "dictionary": "The family of markers, with OpenCV's name without DICT_.",
    "duration": "Of one gust, seconds.",
    "edge_width": "Of the edge lines, metres.",
    "edges": "The colour of edge lines; without it there are none.",
    "every": "Mean time from the beginning of one gust to that of the next.",
    "faces": "It stands upright and is seen from this direction; without it, it lies flat.",
    "file": "Named from this file's folder.",
    "fence": "The space to stay in: a polygon with floor and ceiling.",
    "floor": "Least height to fly at, metres.",
    "from": "The compass bearing it comes from, degrees clockwise from north.",
    "gaps": "Stretches without road, [from, to] in metres along it.",
    "gates": "Frames to fly through along `heading`.",
    "ground": "The colour, size, picture and hills of the ground.",
    "gusts": "The speed of the wind in its gusts, or their speed, duration and times.",
    "heading": "Counter-clockwise from east: 90 deg faces north.",
    "height": "Metres; of the sun, its angle above the horizon; of a wind, where it has its speed.",
    "heights": "As on a map: the first row is north. 0 along the border.",
    "houses": "Flat-roofed houses, the door in front.",
    "id": "Number of the marker in its dictionary.",
    "inside": "A smaller marker in the middle of a marker, of another dictionary.",
    "lat": "Degrees north.",
    "lean": "Leans it back; 90 deg would lay it down.",
    "light": "The sun and the sky.",
    "lon": "Degrees east.",
    "loop": "Whether it leads round, back to its first point.",
    "lying": "Whether the person lies, the head towards `heading`.",
    "marker": "On a box, a marker on its top; on a board, the side of its markers.",
    "markers": "Fiducial markers, flat or standing.",
    "meshes": "Triangles of .obj and .stl files.",
    "model": "The model of its vehicles: a name, or a file named from this file's folder.",
    "models": "The shapes of .urdf and .sdf files.",
    "moves": "A path that it follows at a constant speed, instead of `at`.",
    "origin": "Where (0, 0, 0) is on the Earth.",
    "people": "People, 1.75 m tall.",
    "places": "Names for points: [x, y, z], metres.",
    "radius": "Metres.",
    "roads": "Painted roads.",
    "roof": "The colour of the roof.",
    "roughness": "Roughness length of the ground: the wind grows with height. Grass is 3 cm.",
    "roundels": "Black discs with a line at the right of where they point, flat.",
    "rows": "Squares along its height.",
    "scale": "What its lengths are multiplied with.",
    "signs": "Boards on a post.",
    "size": "Metres: one side, or along each of its own axes; of a marker its black square, of "
    "a roundel its disc.",
    "sky": "The colour of the sky.",
    "smooth": "Whether it is a curve through all its points.",
    "speed": "How fast it goes.",
    "spheres": "Balls.",
    "square": "The side of one square of the board.",
    "start": "Where vehicles stand when the run begins: one place, or a list.",
    "terrain": "Hills: heights over a square about the origin.",
    "texture": "A PNG or JPEG file, named from this file's folder.",
    "thickness": "Metres.",
    "through": "The points it leads through.",
    "tile": "The side of one tile of the picture, metres.",
    "to": "The speed of the wind at the peak of a gust.",
    "top": "Height of the upper edge, metres.",
    "trees": "Trees: a trunk and a round crown.",
    "turn": "Turns it in its own plane, counter-clockwise.",
    "turbulence": "natural, light, moderate, severe, or the wind 20 feet above ground.",
    "turns": "Whether it faces where it goes.",
    "walls": "Straight walls from point to point.",
    "width": "Metres.",
    "wind": "Speed and compass bearing it comes from: 5 m/s@270 deg; or a map; or none.",
    "world": "The world's name.",
}
"""The help for each key that editors show."""


def world_schema() -> dict[str, Any]:
    """The JSON Schema (2020-12) of world files: keys, types, bounds and words.

    Rules about more than one value (names used twice, starts in things) and missing files are left
    to the loader.
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "World",
        **_explained(fields_schema(FIELDS)),
    }


def _explained(schema: Any) -> Any:
    """A schema with help for every key."""
    if isinstance(schema, list | tuple):
        return [_explained(part) for part in schema]
    if not isinstance(schema, Mapping):
        return schema
    found = {word: _explained(part) for word, part in schema.items() if word != "properties"}
    if "properties" in schema:
        found["properties"] = {
            key: {**_explained(value), "description": HELP[key]}
            for key, value in schema["properties"].items()
        }
    return found

"""Reads robot and model descriptions (URDF, SDF) as rigid groups of shapes.

Of either format this takes the boxes, cylinders, spheres and meshes of all links, with joints at
zero. A link collides with the shapes that are seen of it; one without visuals is made of its
collision shapes. Joints do not move, and plugins, sensors, physics settings and materials beyond a
plain colour are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import isfinite
from pathlib import Path
from xml.etree import ElementTree

from vencejo.geometry import Point, Pose, about_x, about_y, product, turned, yaw_quaternion
from worlds.mesh_files import load_mesh
from worlds.things import UPRIGHT, Color, Cuboid, Cylinder, Mesh, Part, Shape, Sphere

_GRAY: Color = (128, 128, 128)
_ZERO = Point(0.0, 0.0, 0.0)


def load_model(path: Path) -> tuple[Part, ...]:
    """The parts of a model, in the frame of its root link.

    Raises ValueError; its message tells what is wrong with the file.
    """
    root = _root(path)
    if any("xacro" in element.tag for element in root.iter()):
        raise ValueError("xacro is a macro language; expand it first: xacro FILE > model.urdf")
    if root.tag == "robot":
        parts = tuple(_urdf(root, path.parent))
    elif root.tag == "sdf":
        parts = tuple(_sdf(root, path.parent))
    else:
        raise ValueError(f"its root is <{root.tag}>; <robot> (URDF) or <sdf> is needed")
    if not parts:
        raise ValueError("none of its links has a shape")
    return parts


def _root(path: Path) -> ElementTree.Element:
    """The root of an XML file. Raises ValueError."""
    text = path.read_text("utf-8", "replace")
    if "<!ENTITY" in text or "<!DOCTYPE" in text:
        raise ValueError("document types and entities are not read")
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"it is no XML ({error})") from None


def mesh_files_of(path: Path) -> tuple[Path, ...]:
    """The meshes that a model's file names and that exist; none of a file that is no model."""
    try:
        root = _root(path)
    except (OSError, ValueError):
        return ()
    words = [_urdf_sizes(mesh, "file") or _sdf_sizes(mesh, "file") for mesh in root.iter("mesh")]
    files = [path.parent / _mesh_name(word) for word in words if word]
    return tuple(file for file in files if file.is_file())


# URDF: joints place links in each other. http://wiki.ros.org/urdf/XML


def _urdf(robot: ElementTree.Element, folder: Path) -> Iterator[Part]:
    colors = {m.get("name"): _urdf_color(m) for m in robot.findall("material")}
    poses = _link_poses(robot)
    for link in robot.findall("link"):
        for element in _shapes_of(link):
            material = element.find("material")
            color = _GRAY
            if material is not None:
                known = colors.get(material.get("name")) or _GRAY
                color = _urdf_color(material) or known
            pose = _joined(poses[link.get("name", "")], _origin(element))
            yield _part(element, _urdf_sizes, folder, pose, color)


def _link_poses(robot: ElementTree.Element) -> dict[str, Pose]:
    """The pose of each link in the frame of the root. Raises ValueError."""
    names = {link.get("name", "") for link in robot.findall("link")}
    parents: dict[str, tuple[str, Pose]] = {}
    for joint in robot.findall("joint"):
        ends = [joint.find(end) for end in ("parent", "child")]
        parent, child = (end.get("link", "") if end is not None else "" for end in ends)
        for name in (parent, child):
            if name not in names:
                raise ValueError(f"joint '{joint.get('name')}' names the unknown link '{name}'")
        parents[child] = (parent, _origin(joint))
    poses = dict.fromkeys(names - set(parents), (_ZERO, UPRIGHT))
    while parents:
        ready = [child for child, (parent, _) in parents.items() if parent in poses]
        if not ready:
            raise ValueError(f"the joints of {', '.join(sorted(parents))} lead in a circle")
        for child in ready:
            parent, pose = parents.pop(child)
            poses[child] = _joined(poses[parent], pose)
    return poses


def _origin(element: ElementTree.Element) -> Pose:
    origin = element.find("origin")
    if origin is None:
        return _ZERO, UPRIGHT
    return _pose(
        [*_numbers(origin.get("xyz", "0 0 0"), 3), *_numbers(origin.get("rpy", "0 0 0"), 3)]
    )


def _urdf_color(material: ElementTree.Element) -> Color | None:
    color = material.find("color")
    return None if color is None else _rgb(color.get("rgba", "0.5 0.5 0.5 1"))


def _urdf_sizes(shape: ElementTree.Element, name: str) -> str | None:
    return shape.get({"file": "filename"}.get(name, name))


# SDF: links have poses in their model. http://sdformat.org/spec


def _sdf(root: ElementTree.Element, folder: Path) -> Iterator[Part]:
    for element in root.iter():
        if element.tag == "include":
            raise ValueError("<include> is not read; name the included file itself")
        if element.get("relative_to") or element.get("frame"):
            raise ValueError(f"<{element.tag}> relative to another frame is not read")
    models = [*root.findall("model"), *root.findall("world/model")]
    for model in models:
        if model.find("model") is not None:
            raise ValueError("models inside models are not read")
        for link in model.findall("link"):
            for element in _shapes_of(link):
                pose = _joined(_joined(_sdf_pose(model), _sdf_pose(link)), _sdf_pose(element))
                color = element.findtext("material/diffuse") or element.findtext("material/ambient")
                yield _part(element, _sdf_sizes, folder, pose, _rgb(color) if color else _GRAY)


def _sdf_pose(element: ElementTree.Element) -> Pose:
    return _pose(_numbers(element.findtext("pose") or "0 0 0 0 0 0", 6))


def _sdf_sizes(shape: ElementTree.Element, name: str) -> str | None:
    return shape.findtext({"file": "uri"}.get(name, name))


# Both.


def _shapes_of(link: ElementTree.Element) -> list[ElementTree.Element]:
    return link.findall("visual") or link.findall("collision")


def _part(
    element: ElementTree.Element,
    sizes: Callable[[ElementTree.Element, str], str | None],
    folder: Path,
    pose: Pose,
    color: Color,
) -> Part:
    geometry = element.find("geometry")
    if geometry is None or not len(geometry):
        raise ValueError(f"a <{element.tag}> has no geometry")
    form = geometry[0]

    def numbers(name: str, count: int = 1) -> list[float]:
        text = sizes(form, name)
        if text is None:
            raise ValueError(f"a <{form.tag}> has no {name}")
        values = _numbers(text, count)
        if any(value <= 0 for value in values):
            raise ValueError(f"the {name} '{text}' of a <{form.tag}> must be above 0")
        return values

    shape: Shape
    if form.tag == "box":
        shape = Cuboid(Point(*numbers("size", 3)))
    elif form.tag == "cylinder":
        shape = Cylinder(*numbers("radius"), *numbers("length"))
    elif form.tag == "sphere":
        shape = Sphere(numbers("radius")[0])
    elif form.tag == "mesh":
        scale = numbers("scale", 3) if sizes(form, "scale") else [1.0, 1.0, 1.0]
        shape = _mesh(folder, sizes(form, "file") or "", scale)
    else:
        raise ValueError(f"the shape <{form.tag}> is not known (box, cylinder, sphere, mesh are)")
    return Part(shape, *pose, color)


def _mesh_name(word: str) -> str:
    return word.strip().removeprefix("file://")


def _mesh(folder: Path, word: str, scale: list[float]) -> Mesh:
    name = _mesh_name(word)
    if "://" in name:
        raise ValueError(f"the mesh '{word}' is not found; give its path from the model's folder")
    if not (folder / name).is_file():
        raise ValueError(f"there is no mesh '{folder / name}'")
    mesh = load_mesh(folder / name)
    return Mesh(mesh.vertices * scale, mesh.faces)


def _joined(outer: Pose, inner: Pose) -> Pose:
    """The pose, in an outermost frame, of a frame whose pose in another one is ``inner``."""
    return outer[0].plus(turned(inner[0], outer[1])), product(outer[1], inner[1])


def _pose(values: list[float]) -> Pose:
    """The pose of x, y, z (metres), roll, pitch and yaw (radians, about fixed axes)."""
    x, y, z, roll, pitch, yaw = values
    attitude = product(product(yaw_quaternion(yaw), about_y(pitch)), about_x(roll))
    return Point(x, y, z), attitude


def _numbers(text: str, count: int) -> list[float]:
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not all(map(isfinite, values)):
        raise ValueError(f"'{text.strip()}' is not {count} numbers")
    return values


def _rgb(text: str) -> Color:
    red, green, blue = (round(255 * min(1.0, max(0.0, v))) for v in _numbers(text, 4)[:3])
    return red, green, blue

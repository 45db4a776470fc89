"""Reads triangle meshes from Wavefront OBJ and STL files."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from worlds.things import Mesh

MOST_TRIANGLES = 50_000


def load_mesh(path: Path) -> Mesh:
    """The mesh of an OBJ file (vertices and faces only) or an STL file (text or binary).

    Raises ValueError; its message tells what is wrong with the file.
    """
    suffix = path.suffix.lower()
    if suffix not in (".obj", ".stl"):
        raise ValueError(f"files end in .obj or .stl, not '{path.suffix}'")
    data = path.read_bytes()
    vertices, faces = _read_obj(data) if suffix == ".obj" else _read_stl(data)
    if not len(faces):
        raise ValueError("it has no triangles")
    if len(faces) > MOST_TRIANGLES:
        raise ValueError(f"it has {len(faces)} triangles; {MOST_TRIANGLES} are the limit")
    if not np.isfinite(vertices).all():
        raise ValueError("a coordinate is no finite number")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise ValueError("a face names a corner that is not there")
    return Mesh(vertices, faces)


def _read_obj(data: bytes) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    vertices: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), 1):
        words = line.split()
        try:
            if line.startswith("v "):
                vertices.append([float(word) for word in words[1:4]])
                if len(words) < 4:
                    raise ValueError
            elif line.startswith("f "):
                corners = [_corner(word, len(vertices)) for word in words[1:]]
                if len(corners) < 3:
                    raise ValueError
                faces += [(corners[0], *pair) for pair in pairwise(corners[1:])]
        except ValueError:
            raise ValueError(f"line {number} cannot be read: {line.strip()[:60]}") from None
    return np.array(vertices, float).reshape(-1, 3), np.array(faces, np.int32).reshape(-1, 3)


def _corner(word: str, known: int) -> int:
    """The index of a vertex, from 0, of a face's word: ``7``, ``7/1/2``, or ``-1`` for the last."""
    number = int(word.partition("/")[0])
    return number - 1 if number > 0 else known + number if number < 0 else -1


_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def _read_stl(data: bytes) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    count = int.from_bytes(data[80:84], "little")
    if len(data) >= 84 and len(data) == 84 + count * _TRIANGLE.itemsize:
        corners = np.frombuffer(data, _TRIANGLE, count, 84)["corners"].reshape(-1, 3)
    elif data.lstrip().startswith(b"solid"):
        lines = (line.split() for line in data.splitlines())
        found = [words[1:4] for words in lines if words[:1] == [b"vertex"]]
        try:
            corners = np.array([[float(v) for v in words] for words in found]).reshape(-1, 3)
        except ValueError:
            raise ValueError("a vertex is not three numbers") from None
        if len(corners) % 3:
            raise ValueError("a triangle is not complete")
    else:
        raise ValueError("the STL file is broken or cut short")
    vertices, index = np.unique(corners.astype(float), axis=0, return_inverse=True)
    return vertices, index.reshape(-1, 3).astype(np.int32)

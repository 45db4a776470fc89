"""Files that a world file names: images, meshes, models.

Images are checked without decoding them, so that loading stays quick.
"""

from __future__ import annotations

from pathlib import Path
from zlib import crc32

from vencejo.errors import UserError, nearest
from vencejo.nodes import YamlNode
from worlds.things import Image
from worlds.values import TEXT, Value

_PNG = b"\x89PNG\r\n\x1a\n"


def image_problem(path: Path) -> str | None:
    """Tell what is wrong with a PNG or JPEG file; None when it is whole."""
    try:
        data = path.read_bytes()
    except OSError as error:
        return (error.strerror or str(error)).lower()
    if data.startswith(_PNG):
        return None if _png_is_whole(data) else "the PNG file is broken or cut short"
    if data.startswith(b"\xff\xd8\xff"):
        whole = b"\xff\xd9" in data[-64:]  # some cameras pad the file
        return None if whole else "the JPEG file is cut short"
    return "it is neither PNG nor JPEG"


def _png_is_whole(data: bytes) -> bool:
    """Whether all chunks are there and their checksums right (PNG specification, section 5)."""
    at = len(_PNG)
    while at + 12 <= len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        # The checksum is of the chunk's type and data.
        body, checksum_at = data[at + 4 : at + 8 + size], at + 8 + size
        if crc32(body) != int.from_bytes(data[checksum_at : checksum_at + 4], "big"):
            return False
        if body[:4] == b"IEND":
            return True
        at = checksum_at + 4
    return False


def _image(node: YamlNode) -> Image:
    path = file_of(node)
    problem = image_problem(path)
    if problem is not None:
        raise UserError("bad-picture", f"'{path}' cannot be shown: {problem}", node.where)
    return Image(path)


def file_of(node: YamlNode) -> Path:
    """The path of the file that a text names, from the world file's folder.

    Raises UserError (``no-such-file``, ``wrong-type``).
    """
    path = Path(node.where.file).parent / TEXT.read(node)
    if not path.is_file():
        others = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
        hint = nearest(path.name, others, "paths begin at the world file's folder")
        raise UserError("no-such-file", f"there is no file '{path}'", node.where, hint)
    return path


IMAGE = Value(_image, {"type": "string"})
"""A PNG or JPEG file, whole."""

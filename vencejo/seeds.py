"""Named random generators: every random draw of a run depends on its seed and a name."""

from __future__ import annotations

from hashlib import sha256
from random import Random


def generator(seed: int, *names: str) -> Random:
    """The random generator of a name in a run with a seed; equal arguments give equal draws.

    Generators of different names are independent: more draws from one change no other.
    """
    key = "\x1f".join((str(seed), *names))
    return Random(int.from_bytes(sha256(key.encode()).digest()[:16], "big"))

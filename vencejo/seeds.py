"""Named random generators: every draw of a run comes from its seed and a name."""

from __future__ import annotations

from hashlib import sha256
from random import Random


def generator(seed: int, *names: str) -> Random:
    """The generator of that name in a run of that seed; equal arguments give equal draws.

    Independent of every other name, so that a draw added in one place moves none elsewhere.
    """
    key = "\x1f".join((str(seed), *names))
    return Random(int.from_bytes(sha256(key.encode()).digest()[:16], "big"))

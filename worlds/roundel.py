"""The oriented roundel: a black disc with a white rectangle, and a black line at its right.

After Parrot's black-and-white oriented roundel, as C. M. Hernández Phillips describes it
(*Plataforma de comunicación entre Live Robot Programming y el robot AR.Drone 2.0*, Universidad de
Chile 2016, section 3.4); the proportions are ours. Seen with the line at the right it points up.
Lengths are in diameters of the disc, from its centre: x to the right, y up.
"""

from __future__ import annotations

from math import pi

from vencejo.geometry import yaw_quaternion
from worlds import figures
from worlds.things import Part, Roundel

PLATE = 1.8
"""Side of the white square it is on."""
HOLE = (0.2, 0.5)
"""Width and height of the white rectangle in the middle of the disc."""
LINE = (0.14, 1.2)
"""Width and height of the line."""
LINE_AT = 0.7
"""The place of the middle of the line, to the right."""


def roundel_parts(size: float) -> tuple[Part, ...]:
    """A roundel that lies flat and points forward; ``size`` is the diameter of the disc, metres."""
    side = PLATE * size
    return (figures.plate(side, side, yaw_quaternion(-pi / 2), Roundel()),)

"""The pixels that each thing covers, compared with pybullet's software renderer."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

from hal.raster import Raster
from hal.raster.camera import NEAR
from hal.sim.bullet_renderers import TinyRenderer
from tests.hal.engines import needs_pybullet
from tests.hal.scenes import clutter, lens, look

LENS = lens(320, 240)


pytestmark = needs_pybullet


class Reference(TinyRenderer):
    near = NEAR


def agrees(seed: int) -> None:
    """One seeded scene: every object covers the same pixels in both pictures."""
    draw = Random(seed)
    world = clutter(draw)
    at = (draw.uniform(-10, 10), draw.uniform(-10, 10), draw.uniform(0.3, 6))
    up = (draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1))
    pose = look(at, (draw.uniform(-2, 2), draw.uniform(-2, 2), draw.uniform(0, 2)), up)
    raster, reference = Raster(world, {}), Reference(world, {})
    try:
        image = raster.render(pose, LENS, 0.0, {})
        _, bodies = reference.look(pose, LENS, 0.0, {})
        names = reference.names
    finally:
        reference.close()
    same = np.zeros((240, 320), bool)
    for thing in world.things:
        mine = (image == thing.parts[0].color[::-1]).all(2)
        others = np.isin(bodies, [body for body, name in names.items() if name == thing.name])
        same |= mine & others
        together = int((mine | others).sum())
        if together > 60:
            share = int((mine & others).sum()) / together
            assert share >= 0.97, f"seed {seed}: {thing.name} agrees on {share:.1%} of {together}"
    objects = np.isin(bodies, list(names))
    # What is hidden wrongly would be missing here, however small.
    assert (same | ~objects).mean() > 0.998, f"seed {seed}"


@pytest.mark.parametrize("seed", range(10))
def test_masks_and_occlusion_agree_with_the_reference(seed: int) -> None:
    agrees(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 100))
def test_masks_and_occlusion_agree_in_a_hundred_scenes(seed: int) -> None:
    agrees(seed)

"""Connected parts of masks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from behaviors.perception.blobs import blobs, touches_edge

rows = st.tuples(st.integers(0, 40), st.integers(0, 30), st.integers(1, 20), st.integers(1, 15))


@settings(deadline=None)
@given(rows)
def test_a_rectangle_is_one_blob(rectangle: tuple[int, int, int, int]) -> None:
    left, top, width, height = rectangle
    mask = np.zeros((50, 70), np.uint8)
    mask[top : top + height, left : left + width] = 255
    [blob] = blobs(mask)
    assert blob.area == width * height
    assert (blob.x, blob.y) == pytest.approx((left + (width - 1) / 2, top + (height - 1) / 2))
    assert blob.box == (left, top, left + width, top + height)
    assert (blob.width, blob.height) == (width, height)
    assert touches_edge(blob, mask) == (left == 0 or top == 0)


def test_blobs_are_bounded_in_area_and_come_largest_first() -> None:
    mask = np.zeros((40, 60), np.uint8)
    for left, side in ((2, 4), (20, 10), (40, 7)):
        mask[5 : 5 + side, left : left + side] = 1
    assert [blob.area for blob in blobs(mask)] == [100, 49, 16]
    assert [blob.area for blob in blobs(mask, 20, 60)] == [49]


@pytest.mark.parametrize("shape", [(1, 1), (16, 16), (240, 320)])
def test_an_empty_and_a_full_mask(shape: tuple[int, int]) -> None:
    assert blobs(np.zeros(shape, np.uint8)) == []
    [blob] = blobs(np.full(shape, 255, np.uint8))
    assert blob.area == shape[0] * shape[1]
    assert touches_edge(blob, np.zeros(shape, np.uint8))

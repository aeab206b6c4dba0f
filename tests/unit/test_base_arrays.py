"""Arrays whose components lie apart in memory, and those that only repeat."""

import numpy as np

from cardan.base.arrays import apart, distinct, last, layers, own, stacked, vectors

RNG = np.random.default_rng(5)


def test_components_lie_apart_and_mean_the_same():
    values = RNG.normal(size=(4, 7, 3, 2))
    for of in (1, 2):
        found = apart(values, of=of)
        np.testing.assert_array_equal(found, values)
        lead = np.moveaxis(found, range(-of, 0), range(of))
        assert lead.flags.c_contiguous
    # And what is made of them keeps the order.
    assert np.moveaxis(2 * apart(values), -1, 0).flags.c_contiguous


def test_numbers_stand_side_by_side_component_by_component():
    x, y = RNG.normal(size=(5, 1)), RNG.normal(size=(4,))
    found = stacked((x, y, 2.0))
    assert found.shape == (5, 4, 3)
    np.testing.assert_array_equal(found[..., 0], np.broadcast_to(x, (5, 4)))
    np.testing.assert_array_equal(found[..., 2], 2.0)
    assert np.moveaxis(found, -1, 0).flags.c_contiguous
    np.testing.assert_array_equal(last(np.moveaxis(found, -1, 0)), found)


def test_points_are_vectors():
    found = vectors([(1.0, RNG.normal(size=6), 3.0), (4.0, 5.0, 6.0)])
    assert found.shape == (6, 2, 3)
    np.testing.assert_array_equal(found[:, 1], np.broadcast_to([4.0, 5.0, 6.0], (6, 3)))
    assert vectors([], size=2).shape == (0, 2)


def test_what_only_repeats_is_one():
    small = RNG.normal(size=(3, 1, 2))
    wide = np.broadcast_to(small, (3, 900, 2))
    np.testing.assert_array_equal(own(wide), small)
    assert own(small) is small


def test_layers_are_a_new_axis_that_lies_first_in_memory():
    parts = [apart(RNG.normal(size=(5, 3, 2))) for _ in range(4)]
    for axis in (-3, -1, 0):
        found = layers(parts, axis=axis)
        np.testing.assert_array_equal(found, np.stack(parts, axis=axis))
        assert all(np.shares_memory(v, found) for v in np.moveaxis(found, axis, 0))
        assert max(found.strides) == found.strides[axis]


def test_numbers_that_come_again_are_told_once():
    values = RNG.integers(0, 4, size=(9, 3, 2)).astype(float)
    where, which = distinct(values)
    np.testing.assert_array_equal(values[where][which], values)
    assert len(where[0]) == sum(len(set(values[:, i, j])) for i in range(3) for j in range(2))

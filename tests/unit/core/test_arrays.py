"""Arrays whose components lie apart in memory, and those that only repeat."""

import numpy as np

from cardan.core.arrays import (
    collapse_broadcast_axes,
    first_axis_last,
    make_components_contiguous,
    stack_keeping_parts_contiguous,
    stack_on_last_axis,
    stack_vectors_on_last_axes,
    unique_along_first_axis,
)

RNG = np.random.default_rng(5)


def test_component_first_memory_layout_keeps_values():
    values = RNG.normal(size=(4, 7, 3, 2))
    for of in (1, 2):
        found = make_components_contiguous(values, of=of)
        np.testing.assert_array_equal(found, values)
        lead = np.moveaxis(found, range(-of, 0), range(of))
        assert lead.flags.c_contiguous
    # And what is made of them keeps the order.
    assert np.moveaxis(2 * make_components_contiguous(values), -1, 0).flags.c_contiguous


def test_stacked_broadcasts_components_in_component_first_layout():
    x, y = RNG.normal(size=(5, 1)), RNG.normal(size=(4,))
    found = stack_on_last_axis((x, y, 2.0))
    assert found.shape == (5, 4, 3)
    np.testing.assert_array_equal(found[..., 0], np.broadcast_to(x, (5, 4)))
    np.testing.assert_array_equal(found[..., 2], 2.0)
    assert np.moveaxis(found, -1, 0).flags.c_contiguous
    np.testing.assert_array_equal(first_axis_last(np.moveaxis(found, -1, 0)), found)


def test_vectors_stacks_points_of_many_cases():
    found = stack_vectors_on_last_axes([(1.0, RNG.normal(size=6), 3.0), (4.0, 5.0, 6.0)])
    assert found.shape == (6, 2, 3)
    np.testing.assert_array_equal(found[:, 1], np.broadcast_to([4.0, 5.0, 6.0], (6, 3)))
    assert stack_vectors_on_last_axes([], size=2).shape == (0, 2)


def test_broadcast_axis_is_reduced_to_length_one():
    small = RNG.normal(size=(3, 1, 2))
    wide = np.broadcast_to(small, (3, 900, 2))
    np.testing.assert_array_equal(collapse_broadcast_axes(wide), small)
    assert collapse_broadcast_axes(small) is small


def test_layers_add_outermost_memory_axis():
    parts = [make_components_contiguous(RNG.normal(size=(5, 3, 2))) for _ in range(4)]
    for axis in (-3, -1, 0):
        found = stack_keeping_parts_contiguous(parts, axis=axis)
        np.testing.assert_array_equal(found, np.stack(parts, axis=axis))
        assert all(np.shares_memory(v, found) for v in np.moveaxis(found, axis, 0))
        assert max(found.strides) == found.strides[axis]


def test_distinct_lists_repeated_values_once():
    values = RNG.integers(0, 4, size=(9, 3, 2)).astype(float)
    where, which = unique_along_first_axis(values)
    np.testing.assert_array_equal(values[where][which], values)
    assert len(where[0]) == sum(len(set(values[:, i, j])) for i in range(3) for j in range(2))

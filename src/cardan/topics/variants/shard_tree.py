"""Shards merged two by two in a fixed order: to the same bit wherever and whenever that is.

A node of level n and index i stands for the shards from i 2^n up to (i + 1) 2^n. Its state is that
of its two halves, merged. A worker that computes all shards of a node may merge them, so its result
does not grow with the number of its shards.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

from cardan.topics.variants.statistics import StatisticState, StreamingStatistic

ShardNode: TypeAlias = tuple[int, int]
"""Level and index."""
ShardStatistics: TypeAlias = Mapping[str, StatisticState]
"""Statistics of shards, by name."""


def shards_of(node: ShardNode) -> range:
    """Return the numbers of a node's shards."""
    level, index = node
    return range(index << level, (index + 1) << level)


def next_node(todo: Sequence[int], at: int, most: float) -> ShardNode:
    """Return the largest node of at most so many shards of which the first is `todo[at]`.

    All of them must be there, in `todo`, which rises.
    """
    level, first = 0, todo[at]
    while (2 << level) <= most and first % (2 << level) == 0:
        last = at + (2 << level) - 1
        if last >= len(todo) or todo[last] != first + (2 << level) - 1:
            break
        level += 1
    return level, first >> level


def merged_statistics(
    of: Mapping[str, StreamingStatistic], parts: Mapping[ShardNode, ShardStatistics]
) -> ShardStatistics:
    """Return the statistics of all parts together; {} of none. No two parts share a shard."""
    parts, level = dict(parts), 0
    while len(parts) > 1 or any(at != (level, 0) for at in parts):
        if not parts:
            return {}
        parts = dict(_one_level_up(of, parts, level))
        level += 1
    return next(iter(parts.values()), {})


def _one_level_up(
    of: Mapping[str, StreamingStatistic], parts: Mapping[ShardNode, ShardStatistics], level: int
) -> Iterator[tuple[ShardNode, ShardStatistics]]:
    """Yield parts with those of a level merged in pairs, the earlier first; one alone stays."""
    for (own, index), found in parts.items():
        if own != level:
            yield (own, index), found
            continue
        beside = parts.get((level, index ^ 1))
        if beside is None:
            yield (level + 1, index >> 1), found
        elif index % 2 == 0:
            yield (
                (level + 1, index >> 1),
                {n: r.merge(found[n], beside[n]) for n, r in of.items()},
            )

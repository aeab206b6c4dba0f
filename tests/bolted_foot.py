"""A rigid foot on two rows of springs, with one bolt."""

from dataclasses import replace

import numpy as np

from cardan.physics.fem.bolted_joint import BoltedFlange

WIDE, COUNT = 0.3, 60


Y = (np.arange(COUNT) + 0.5) / COUNT * WIDE - WIDE / 2


def foot(*, out_of_middle=0.0):
    """Two rows of patches along y, on springs of their own; one bolt, out of the middle along y."""
    places = np.array([(x, y, 0.0) for x in (-0.01, 0.01) for y in Y])
    ways = np.tile(np.eye(3), (len(places), 1))
    at = np.repeat(places, 3, axis=0)
    ways = np.concatenate([ways, np.eye(3)[[2]], np.eye(3), np.zeros((6, 3))])
    at = np.concatenate([at, [(0.0, out_of_middle, 0.0)], np.zeros((9, 3))])
    rigid = np.concatenate([ways, np.cross(at, ways)], axis=1)
    gives = np.where(np.arange(len(ways)) < 3 * len(places), 1e-9, 0.0)
    return BoltedFlange(
        compliance=np.diag(gives),
        rigid_body_work=rigid,
        stress=np.zeros((len(ways), 0, 6)),
        bolt_axis=2,
        bolt_count=1,
        patch_areas=np.full(len(places), 1e-4),
    )


def coupled(rng):
    """The same on an elastic ground that what presses dents around it."""
    of = foot()
    places = np.array([(x, y) for x in (-0.01, 0.01) for y in Y])
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1)
    dent = 1e-9 / (1 + apart / 0.01) * (1 + 0.3 * rng.random())
    compliance = np.zeros_like(of.compliance)
    compliance[: 6 * COUNT, : 6 * COUNT] = np.kron(dent, np.diag([1.2, 1.2, 1.0]))
    return replace(of, compliance=compliance, rigid_body_work=np.concatenate([
        of.rigid_body_work[: 6 * COUNT + 4], np.eye(6)[3:], np.zeros((3, 6))
    ]))  # fmt: skip

"""Edges of a meshed body where stress has no limit: notches without a radius, ends of a clamp."""

import numpy as np

from cardan.physics.fem.surface import MIN_RE_ENTRANT_ANGLE_RAD, find_surface_edges


def singular_edge_points(nodes, *, held):
    """Return points (k, 3) m along edges in a notch, or at the border of the `held` faces.

    Source: Williams, J. Appl. Mech. 19 (1952) 526.
    """
    edges = find_surface_edges(nodes)
    on = np.isin(nodes.face_names, held)
    notched = edges.turn_angle > MIN_RE_ENTRANT_ANGLE_RAD
    sharp = notched | (on[edges.faces] != on[edges.opposite_faces])
    return nodes.points[np.unique(edges.nodes[sharp])]

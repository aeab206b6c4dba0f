"""The bracket as an elastic solid: shape, unit loads, stresses, gauges, modes.

Needs the extra `cardan[bracket]` (NGSolve with Netgen), imported where it is used.
"""

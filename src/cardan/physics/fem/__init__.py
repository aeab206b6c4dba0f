"""Finite elements of the bracket. Needs the extra `cardan[bracket]` (NGSolve), imported late."""

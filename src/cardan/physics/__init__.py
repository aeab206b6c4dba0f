"""Physics: pure functions on arrays, in SI units."""

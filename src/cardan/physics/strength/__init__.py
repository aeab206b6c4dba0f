"""Strength of shafts: critical speed, stresses, bearing life, composite tubes."""

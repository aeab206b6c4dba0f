"""Knows what a recorded stress does to metal: cycles, damage, cracks, odds and causes."""

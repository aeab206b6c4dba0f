"""Textbook fatigue: cycle counting, S-N curves, damage, crack growth, reliability."""

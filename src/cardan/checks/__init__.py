"""Checks: every quantity of a line, declared once, with the worst operating point for each."""

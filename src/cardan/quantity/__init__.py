"""Quantities: each declared once, with how a line answers it."""

"""Kinematics of universal joints: one, a chain of them, equivalent angle."""

"""Cardan: universal-joint drivelines, from hardpoints to verdict."""

__version__ = "0.1.0"

"""Vibration of the powertrain: torsional modes, stability, launch."""

"""Torsional and lateral vibration, stability, run-up, backlash."""

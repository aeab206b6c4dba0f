"""Detectors of sensor and recorder faults."""

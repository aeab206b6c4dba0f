"""Foundations: units, errors, verdicts, provenance, messages, arrays."""

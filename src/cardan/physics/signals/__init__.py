"""Recorded signals: conditioning, order tracking, data quality, attribution of damage."""

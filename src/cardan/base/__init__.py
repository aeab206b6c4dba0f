"""What everything stands on: units, sources, quantities, verdicts, errors."""

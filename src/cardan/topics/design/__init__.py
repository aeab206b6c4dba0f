"""Design: corrections, sizing, sensitivities, tolerances, yoke phasing, part selection."""

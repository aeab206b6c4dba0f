"""How a driveline vibrates, and when it is unstable: torsion, lateral, run-up, clearance."""

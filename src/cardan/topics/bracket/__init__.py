"""The centre-bearing bracket: stresses, life, forced response, optimisation."""

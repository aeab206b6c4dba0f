"""Field recordings: damage, life, cause, parameter identification, usage."""

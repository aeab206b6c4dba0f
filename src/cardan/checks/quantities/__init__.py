"""The declared quantities, one module a topic."""

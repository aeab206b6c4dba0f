"""Declarative tables: how files are declared, read with line and column, and written safely."""

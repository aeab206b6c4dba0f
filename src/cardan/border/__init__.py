"""The border: how files are declared and read, and how results are written safely."""

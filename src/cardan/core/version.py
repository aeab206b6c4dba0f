"""Version of the package: files, reports and records carry it."""

__version__ = "0.1.0"

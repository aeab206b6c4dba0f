"""Application files: sections, catalogues, limit profiles, plausibility, editing."""

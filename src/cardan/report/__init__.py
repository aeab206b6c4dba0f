"""Show an assessment: terminal tables and the JSON contract."""

"""Published benchmark cases, recomputed."""

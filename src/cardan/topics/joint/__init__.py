"""One universal joint by itself."""

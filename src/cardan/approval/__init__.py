"""Approval: the study protocol, its registry, and the one verdict."""

"""Bounding volume hierarchies over primitives that are known by their boxes alone."""

"""Structures that find what a ray meets: they know boxes and leaf records, and no kinds of shapes."""

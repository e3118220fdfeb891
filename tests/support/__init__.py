"""Tools that tests share; each is itself tested with deliberately wrong input."""

"""Strangers' spellings."""


def translate(document, moved):
    """Return the notes on what was translated."""
    return []

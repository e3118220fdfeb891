"""A small Dr.Jit renderer for the JSON scenes of the 'Automagic' rendering coursework."""

__version__ = "0.1.0"

"""A small Dr.Jit renderer for the JSON scenes of the 'Automagic' rendering coursework."""

from renderer.core import llvm

__version__ = "0.1.0"

llvm.prepare()  # here, because Dr.Jit reads the choice when it is imported, by whichever module comes first

"""`python -m converters.mitsuba scene.json [-o scene.xml]`: write a scene for stock Mitsuba."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

EXIT_DONE, EXIT_BAD_INPUT = 0, 2


def _parser():
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m converters.mitsuba", allow_abbrev=False,
        description="Write a scene as Mitsuba XML, with its meshes and textures in a folder beside it. What stock "
                    "Mitsuba cannot express is replaced by its nearest counterpart, with a warning.")
    parser.add_argument("scene", help="scene file (JSON)")
    parser.add_argument("-o", "--output", metavar="FILE", help="XML file (default: the scene's name in this folder)")
    parser.add_argument("--mode", help="render mode instead of the scene's")
    parser.add_argument("--strict", action="store_true", help="unknown keys are errors")
    parser.add_argument("--quiet", action="store_true", help="no warnings")
    return parser


def main(arguments=None):
    """Return the exit status: 0 done, 2 bad input or output."""
    options = _parser().parse_args(arguments)
    from converters.mitsuba import write_xml
    from renderer.core.errors import RenderError, SceneError, UsageError
    from renderer.scene.loader import load, override

    output = Path(options.output or Path(options.scene).with_suffix(".xml").name)
    try:
        loaded = load(options.scene, strict=options.strict)
        if options.mode:
            loaded = override(loaded, mode=options.mode)
        warnings = (*loaded.warnings, *write_xml(loaded, output))
    except (SceneError, UsageError, RenderError) as error:
        print(error, file=sys.stderr)
        return EXIT_BAD_INPUT
    except OSError as error:
        print(f"{output}: cannot be written: {error.strerror or error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    for warning in () if options.quiet else warnings:
        print(f"warning: {warning}", file=sys.stderr)
    return EXIT_DONE


if __name__ == "__main__":
    sys.exit(main())

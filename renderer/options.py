"""The options of the command line: what there is, how each is read, and what is said about those that cannot be."""

import argparse
import os
import re

from renderer import __version__
from renderer.core.errors import UsageError

COMMANDS = ("doctor", "schema", "compare")
BACKENDS = ("llvm", "cuda")  # as renderer.core.backend has them, which cannot be asked without loading Dr.Jit
ACCELS = ("auto", "bvh", "grid", "none")  # as renderer.scene.arrange has them, which loads Dr.Jit too
ENCODINGS = ("linear", "srgb")
LIMITED = ("mse", "relative_mse", "psnr", "ssim", "flip", "differing_share", "greatest_levels")  # of compare
MAX_SEED = 2**32 - 1
MAX_THREADS = 1024  # more threads than that are a typing mistake that would exhaust the machine
EPILOG = """\
commands in place of a scene:
  doctor                is everything there that rendering needs? If not: what to do
  schema                print the JSON Schema of scene files, for editors
  compare A B           how far picture A is from reference B (see: python -m renderer compare --help)

exit status: 0 done, 1 the render failed, 2 the input cannot be used, 130 interrupted
"""
COMPARISON_EPILOG = """\
examples:
  python -m renderer compare mine.ppm reference.exr -o difference.png
  python -m renderer compare mine.png theirs.png --json --limit flip=0.1 --limit ssim=0.9

exit status: 0 done, 1 something is worse than its limit or could not be written, 2 the input cannot be used
"""


class Parser(argparse.ArgumentParser):
    """A parser whose complaints are exceptions like all other bad input."""

    def __init__(self, **settings):
        super().__init__(allow_abbrev=False, formatter_class=_help_formatter, **settings)

    def error(self, message):
        raise UsageError(f"{message} (see: {self.prog} --help)")

    def _print_message(self, message, file=None):
        """Print help or version; the inherited method would hide a full disk and a closed pipe."""
        print_out(message)


def _help_formatter(prog):
    """Return argparse's formatter of help, with a column for options that all but the longest fit into."""
    return argparse.RawDescriptionHelpFormatter(prog, max_help_position=26)


def build_parser():
    """Return the parser of everything but the commands."""
    from renderer.scene import schema

    parser = Parser(
        prog="python -m renderer", epilog=EPILOG,
        description="Render a JSON scene to a picture. Options take precedence over what the scene file says.",
    )
    parser.add_argument("scene", metavar="SCENE", help="scene file (JSON)")
    _add_contents(parser.add_argument_group("what is rendered").add_argument, schema)
    _add_outputs(parser.add_argument_group("where the picture goes").add_argument, schema)
    _add_means(parser.add_argument_group("how it is computed").add_argument)
    return parser


def _add_contents(add, schema):
    """Declare the options that decide what a picture shows."""
    add("--mode", type=_mode, choices=schema.RENDER_MODES, metavar="MODE", help=" | ".join(schema.RENDER_MODES))
    add("--samples", type=_integer(1, schema.MAX_SAMPLES), metavar="N", help="rays a pixel")
    add("--size", type=_size, metavar="WxH", help="width and height in pixels, e.g. 1200x800")
    add("--bounces", type=_integer(0, schema.MAX_BOUNCES), metavar="N", help="most reflections and refractions")
    add("--time", type=_positive, metavar="S", help="stop after S seconds of rendering")
    add("--error", type=_positive, metavar="E",
        help="stop at an estimated relative error of E; with --time or --error, --samples is the most there may be, "
        "and the scene's own number does not count")
    add("--seed", type=_integer(0, MAX_SEED), default=0, metavar="N", help="seed of the random numbers (default 0)")
    add("--strict", action="store_true", help="treat warnings about the scene file as mistakes")

    add("--pixel", type=_pixel, metavar="X,Y",
        help="render one sample of one pixel (column and row from the top left corner, from 0), print its radiance, "
        "and write nothing")
    add("--sample", type=_integer(0, schema.MAX_SAMPLES - 1), metavar="N", help="which one with --pixel (default 0)")


def _add_outputs(add, schema):
    """Declare the options of files, and of how radiance is shown in them."""
    add("-o", "--output", action="append", metavar="FILE",
        help=".ppm, .png or .exr (linear radiance); repeat it for several files from one render; '-' writes a PPM to "
        "standard output (default: the scene's name with .ppm, in the current folder)")
    add("--tonemap", choices=schema.TONEMAPS, metavar="CURVE", help=" | ".join(schema.TONEMAPS))
    add("--exposure", type=_exposure, metavar="X", help="brightness: radiance is multiplied by X / 0.1")
    add("--encoding", choices=ENCODINGS, metavar="NAME",
        help=" | ".join(ENCODINGS) + ": 8-bit values proportional to light, or the sRGB curve (default: srgb in mode "
        f"{schema.PATHTRACER}, else linear)")
    add("--denoise", action="store_true",
        help="take noise out of the picture (needs the package in requirements/denoise.txt)")


def _add_means(add):
    """Declare the options of backend, structure and threads, and of what is printed."""
    add("--backend", choices=BACKENDS, metavar="NAME", help=" | ".join(BACKENDS) + " (default: what works here)")
    add("--accel", choices=ACCELS, default="auto", metavar="NAME",
        help=" | ".join(ACCELS) + ": how rays find shapes (default auto: bvh for meshes and many shapes)")
    add("--threads", type=_integer(1, MAX_THREADS), metavar="N", help="threads of the CPU (default: all)")
    add("-q", "--quiet", action="store_true", help="print nothing but warnings and errors")
    add("--version", action="version", version=f"renderer {__version__}")


def parse(arguments):
    """Return the options of a render; raises UsageError."""
    parser = build_parser()
    options = _parsed(parser, arguments)
    if options.sample is not None and options.pixel is None:
        parser.error("--sample needs --pixel X,Y")
    if options.scene in COMMANDS and not os.path.exists(options.scene):
        parser.error(f"'{options.scene}' takes no options of a render; it stands in the first place")
    return options


def build_comparison_parser():
    """Return the parser of what follows `compare`."""
    from renderer.scene import schema

    parser = Parser(
        prog="python -m renderer compare", epilog=COMPARISON_EPILOG,
        description="Tell how far a picture is from a reference of one size with it: PPM, PNG, JPEG, EXR, HDR.",
    )
    add = parser.add_argument
    add("picture", metavar="PICTURE", help="what is judged")
    add("reference", metavar="REFERENCE", help="what it should look like")
    add = parser.add_argument_group("what is told").add_argument
    add("-o", "--output", action="append", metavar="FILE",
        help=".ppm or .png: picture, reference and a coloured difference beside one another; .exr: picture less "
        "reference, linear; '-' writes a PPM to standard output, and the table to standard error")
    add("--gain", type=_positive, metavar="X", help="differences in -o are shown X times as large (default: what fits)")
    add("--json", action="store_true", help="print one line of JSON in place of the table")
    add("--limit", type=_limit, action="append", default=[], metavar="MEASURE=VALUE",
        help="exit with status 1 if it is greater (psnr, ssim: smaller); repeat it for several: " + " | ".join(LIMITED))
    add = parser.add_argument_group(
        "how radiance is shown", "For EXR and HDR; an EXR of ours tells these itself, that of the reference first."
    ).add_argument
    add("--exposure", type=_exposure, metavar="X", help="radiance is multiplied by X / 0.1 (default 0.1)")
    add("--tonemap", choices=schema.TONEMAPS, metavar="CURVE", help=" | ".join(schema.TONEMAPS) + " (default linear)")
    add("--encoding", choices=ENCODINGS, metavar="NAME",
        help=" | ".join(ENCODINGS) + ": what 8-bit values are, also where both pictures have 8 bits (default srgb)")
    return parser


def parse_comparison(arguments):
    """Return the options of `compare`; raises UsageError."""
    parser = build_comparison_parser()
    options = _parsed(parser, arguments)
    if options.gain is not None and not options.output:
        parser.error("--gain needs -o FILE")
    if options.json and "-" in (options.output or []):
        parser.error("--json and '-o -' would both be written to standard output")
    return options


def _parsed(parser, arguments):
    """Return the options; raises UsageError with the nearest known name of an unknown option."""
    options, unknown = parser.parse_known_args(arguments)
    if unknown:
        import difflib

        known = [name for action in parser._actions for name in action.option_strings]
        near = difflib.get_close_matches(unknown[0].split("=")[0], known, n=1)
        parser.error(f"unknown argument '{unknown[0]}'" + (f", did you mean '{near[0]}'?" if near else ""))
    return options


def _integer(low, high):
    """Return a reader of whole numbers in a range."""

    def read(text):
        if not re.fullmatch(r"[+-]?[0-9]{1,18}", text) or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"must be a whole number from {low} to {high}, got '{text}'")
        return int(text)

    return read


def _pixel(text):
    """Return (column, row) from `12,34`."""
    match = re.fullmatch(r"([0-9]{1,9}),([0-9]{1,9})", text)
    if not match:
        raise argparse.ArgumentTypeError(f"must look like 12,34, got '{text}'")
    return int(match[1]), int(match[2])


def _mode(text):
    """Return the mode that a name means, also in the spellings that scene files are understood in."""
    from renderer.scene.aliases import understood_mode

    return understood_mode(text)


def _size(text):
    """Return (width, height) from `1200x800`; the loader knows which sizes are allowed."""
    match = re.fullmatch(r"([0-9]{1,9})[xX]([0-9]{1,9})", text)
    if not match:
        raise argparse.ArgumentTypeError(f"must look like 1200x800, got '{text}'")
    return int(match[1]), int(match[2])


def _limit(text):
    """Return (measure, value) from `flip=0.1`."""
    name, _, number = text.partition("=")
    value = _finite(number)
    if name not in LIMITED or value is None:
        raise argparse.ArgumentTypeError(f"must look like flip=0.1, with one of {', '.join(LIMITED)}, got '{text}'")
    return name, value


def _exposure(text):
    """Return a finite number that is not negative."""
    value = _finite(text)
    if value is None or value < 0:
        raise argparse.ArgumentTypeError(f"must be a number of at least 0, got '{text}'")
    return value


def _positive(text):
    """Return a finite number greater than 0."""
    value = _finite(text)
    if value is None or value <= 0:
        raise argparse.ArgumentTypeError(f"must be a number greater than 0, got '{text}'")
    return value


def _finite(text):
    """Return a finite number, or None for what is none."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if abs(value) < float("inf") else None


def print_out(text):
    """Print what was asked for to standard output."""
    from renderer.io import outputs

    with outputs.standard_output() as stream:
        stream.write(text.encode())

"""The command line: arguments in, pictures and messages out, exit statuses.

Messages go to standard error, so that standard output is free for a picture. Nothing heavy is imported before it is
known to be needed: `--help` must not wait for numpy and Dr.Jit, and a wrong argument must not either.
"""

import argparse
import os
import re
import sys
import time

from renderer import __version__
from renderer.core.errors import (
    EXIT_BAD_INPUT, EXIT_DONE, EXIT_FAILED, EXIT_INTERRUPTED, RenderError, SceneError, UsageError,
)

COMMANDS = ("doctor", "schema")
BACKENDS = ("llvm", "cuda")  # as renderer.core.backend has them, which cannot be asked without loading Dr.Jit
ACCELS = ("auto", "bvh", "grid", "none")  # as renderer.scene.arrange has them, which loads Dr.Jit too
ENCODINGS = ("linear", "srgb")
MAX_SEED = 2**32 - 1
MAX_THREADS = 1024  # more threads than that are a typing mistake that would exhaust the machine
BYTES_A_PIXEL = 28  # of the picture in all its forms; 21 for PPM and 25 for EXR were measured at 8000 x 6000
DOCTOR = "python -m renderer doctor"
EPILOG = """\
commands in place of a scene:
  doctor                is everything there that rendering needs? If not: what to do
  schema                print the JSON Schema of scene files, for editors

exit status: 0 done, 1 the render failed, 2 the input cannot be used, 130 interrupted
"""


class Parser(argparse.ArgumentParser):
    """A parser whose complaints are exceptions like all other bad input."""

    def error(self, message):
        raise UsageError(f"{message} (see: {self.prog} --help)")

    def _print_message(self, message, file=None):
        """Print help or version; the inherited method would hide a full disk and a closed pipe."""
        _print(message)


def main(arguments=None):
    """Run the command line (default: that of the process) and return its exit status; argparse may exit by itself."""
    start = time.perf_counter()
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    try:
        return _run(arguments, start)
    except (SceneError, UsageError) as error:
        return _failed(error, EXIT_BAD_INPUT)
    except RenderError as error:
        return _failed(error, EXIT_FAILED)
    except KeyboardInterrupt as error:
        from renderer.interrupt import MESSAGE

        return _failed(error, EXIT_INTERRUPTED, MESSAGE)
    except BrokenPipeError as error:
        return _failed(error, EXIT_FAILED, "standard output: its reader closed it before everything was written")
    except MemoryError as error:
        return _failed(error, EXIT_FAILED, "there is not enough memory for this render; try a smaller --size")
    except Exception as error:
        said = " ".join(str(error).split())
        report = f"please report it with your scene file and what '{DOCTOR}' says (RENDERER_DEBUG=1 shows the place)"
        return _failed(error, EXIT_FAILED, f"unexpected {type(error).__name__}: {said}; {report}")


def build_parser():
    """Return the parser of everything but the commands."""
    from renderer.scene import schema

    parser = Parser(
        prog="python -m renderer", allow_abbrev=False, epilog=EPILOG,
        description="Render a JSON scene to a picture. Options take precedence over what the scene file says.",
        formatter_class=lambda prog: argparse.RawDescriptionHelpFormatter(prog, max_help_position=26),
    )
    parser.add_argument("scene", metavar="SCENE", help="scene file (JSON)")
    add = parser.add_argument_group("what is rendered").add_argument
    add("--mode", choices=schema.RENDER_MODES, metavar="MODE", help=" | ".join(schema.RENDER_MODES))
    add("--samples", type=_integer(1, schema.MAX_SAMPLES), metavar="N", help="rays a pixel")
    add("--size", type=_size, metavar="WxH", help="width and height in pixels, e.g. 1200x800")
    add("--bounces", type=_integer(0, schema.MAX_BOUNCES), metavar="N", help="most reflections and refractions")
    add("--seed", type=_integer(0, MAX_SEED), default=0, metavar="N", help="seed of the random numbers (default 0)")
    add("--strict", action="store_true", help="treat warnings about the scene file as mistakes")

    add = parser.add_argument_group("where the picture goes").add_argument
    add("-o", "--output", action="append", metavar="FILE",
        help=".ppm, .png or .exr (linear radiance); repeat it for several files from one render; '-' writes a PPM to "
        "standard output (default: the scene's name with .ppm, in the current folder)")
    add("--tonemap", choices=schema.TONEMAPS, metavar="CURVE", help=" | ".join(schema.TONEMAPS))
    add("--exposure", type=_exposure, metavar="X", help="brightness: radiance is multiplied by X / 0.1")
    add("--encoding", choices=ENCODINGS, default="linear", metavar="NAME",
        help=" | ".join(ENCODINGS) + ": 8-bit values proportional to light (default), or the sRGB curve")

    add = parser.add_argument_group("how it is computed").add_argument
    add("--backend", choices=BACKENDS, metavar="NAME", help=" | ".join(BACKENDS) + " (default: what works here)")
    add("--accel", choices=ACCELS, default="auto", metavar="NAME",
        help=" | ".join(ACCELS) + ": how rays find shapes (default auto: bvh for meshes and many shapes)")
    add("--threads", type=_integer(1, MAX_THREADS), metavar="N", help="threads of the CPU (default: all)")
    add("-q", "--quiet", action="store_true", help="print nothing but warnings and errors")
    add("--version", action="version", version=f"renderer {__version__}")
    return parser


def _run(arguments, start):
    """Run one command and return its exit status."""
    if arguments and arguments[0] == "doctor":
        from renderer import doctor

        return doctor.main(arguments[1:])
    if arguments and arguments[0] == "schema":
        return _print_schema(arguments[1:])
    return _render(_parse(arguments), start)


def _parse(arguments):
    """Return the options; raises UsageError with the nearest known name of an unknown option."""
    parser = build_parser()
    options, unknown = parser.parse_known_args(arguments)
    if unknown:
        import difflib

        known = [name for action in parser._actions for name in action.option_strings]
        near = difflib.get_close_matches(unknown[0].split("=")[0], known, n=1)
        parser.error(f"unknown argument '{unknown[0]}'" + (f", did you mean '{near[0]}'?" if near else ""))
    if options.scene in COMMANDS and not os.path.exists(options.scene):
        parser.error(f"'{options.scene}' takes no options of a render; it stands alone")
    return options


def _render(options, start):
    """Load, render and write; return the exit status."""
    from renderer.io import outputs
    from renderer.scene import loader

    width, height = options.size or (None, None)
    loaded = loader.load(options.scene, strict=options.strict, mode=options.mode)
    loaded = loader.override(loaded, width=width, height=height, samples=options.samples, nbounces=options.bounces)
    paths = options.output or [os.path.splitext(os.path.basename(options.scene))[0] + ".ppm"]
    outputs.check(paths, _inputs(loaded))
    _check_memory(loaded.description.camera)
    for remark in loaded.warnings:
        if not (remark.is_note and options.quiet):
            _say(f"{'note' if remark.is_note else 'warning'}: {remark}")
    from renderer.interrupt import prompt_interrupt

    with prompt_interrupt():
        rendering = _trace(loaded, options)
        grading = outputs.Grading(options.tonemap, options.exposure, options.encoding)
        outputs.write_all(paths, rendering, grading, _header(loaded, options))
    if not options.quiet:
        _say(_summary(paths, rendering, time.perf_counter() - start))
    return EXIT_DONE


def _check_memory(camera):
    """Refuse a picture that would not fit: the system would end the process without a word."""
    from renderer import machine

    needed, free = camera.width * camera.height * BYTES_A_PIXEL, machine.available_memory()
    if free is not None and needed > free:
        raise UsageError(
            f"a picture of {camera.width} x {camera.height} needs about {needed / 2**30:.1f} GiB of memory, and "
            f"{free / 2**30:.1f} GiB are free; choose a smaller --size"
        )


def _inputs(loaded):
    """Return the files that the scene is made of."""
    textures = {shape.material.texture for _, shape in loaded.shapes}
    return [loaded.path, *(loaded.resolve(texture) for texture in textures if isinstance(texture, str))]


def _trace(loaded, options):
    """Return the rendering, with progress told on the way."""
    from renderer.progress import Progress

    render = _load_engine(options.backend, options.threads)
    progress = Progress(None if options.quiet else sys.stderr)
    try:
        return render(loaded, seed=options.seed, accel=options.accel, progress=progress)
    finally:
        progress.close()


def _load_engine(backend, threads):
    """Return the render function, with Dr.Jit set up; RenderError in plain words if it cannot be loaded."""
    if backend is not None:
        os.environ["RENDERER_BACKEND"] = backend  # read once, when Dr.Jit's types are imported
    from renderer.interrupt import interrupt_held_back

    try:
        with interrupt_held_back():
            from renderer.engine.render import render
            import drjit  # only now: the renderer finds LLVM for it first
    except (ImportError, OSError, RuntimeError) as error:
        raise RenderError(f"Dr.Jit cannot be used here: {error}; '{DOCTOR}' tells what to do") from error
    if threads is not None:
        drjit.set_thread_count(threads)
    return render


def _header(loaded, options):
    """Return the settings that an EXR carries, as text."""
    description = loaded.description
    exposure = description.camera.exposure if options.exposure is None else options.exposure
    settings = {
        "version": __version__, "scene": loaded.path, "mode": description.rendermode, "samples": description.spp,
        "size": f"{description.camera.width}x{description.camera.height}", "seed": options.seed,
        "nbounces": description.nbounces, "exposure": exposure,
    }
    return {f"renderer.{name}": str(value) for name, value in settings.items()}


def _summary(paths, rendering, total):
    """Return the line that every run ends with."""
    from renderer.io import outputs

    timings = rendering.timings
    return (
        f"{', '.join(map(outputs.name, paths))}: "
        f"{rendering.width} x {rendering.height}, {rendering.mode}, "
        f"{rendering.samples} sample{'' if rendering.samples == 1 else 's'} a pixel; "
        f"built in {timings.build:.2f} s, compiled in {timings.compile:.2f} s, rendered in {timings.render:.2f} s "
        f"({rate_in_words(rendering.samples_per_second)} samples/s), total {total:.2f} s"
    )


def rate_in_words(rate):
    """Return a rate with two significant digits and a prefix: `32 M`, `3.2 G`."""
    for limit, prefix in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        value = rate / limit
        if value >= 0.9995:  # below, rounding to whole units of the next prefix gives at most 999
            return f"{value:.1f}{prefix}" if value < 9.95 else f"{value:.0f}{prefix}"
    return f"{rate:.0f}"


def _print_schema(arguments):
    """Print the JSON Schema of scene files."""
    if arguments:
        raise UsageError(f"'schema' takes no arguments, got '{arguments[0]}'")
    from renderer.scene import reference

    _print(reference.schema_json().rstrip("\n") + "\n")
    return EXIT_DONE


def _integer(low, high):
    """Return a reader of whole numbers in a range."""

    def read(text):
        if not re.fullmatch(r"[+-]?[0-9]{1,18}", text) or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"must be a whole number from {low} to {high}, got '{text}'")
        return int(text)

    return read


def _size(text):
    """Return (width, height) from `1200x800`; the loader knows which sizes are allowed."""
    match = re.fullmatch(r"([0-9]{1,9})[xX]([0-9]{1,9})", text)
    if not match:
        raise argparse.ArgumentTypeError(f"must look like 1200x800, got '{text}'")
    return int(match[1]), int(match[2])


def _exposure(text):
    """Return a finite number that is not negative."""
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a number of at least 0, got '{text}'")
    return value


def _failed(error, status, message=None):
    """Tell what went wrong and return the status."""
    if os.environ.get("RENDERER_DEBUG"):
        import traceback

        _say("".join(traceback.format_exception(error)).rstrip())
    _say(str(error) if message is None else message)
    return status


def _print(text):
    """Print what was asked for to standard output."""
    from renderer.io import outputs

    with outputs.standard_output() as stream:
        stream.write(text.encode())


def _say(text):
    """Print a message to standard error; nobody may be listening."""
    try:
        print(text, file=sys.stderr, flush=True)
    except (OSError, ValueError, AttributeError):  # closed by its reader, or never opened
        pass

"""The command line: arguments in, pictures and messages out, exit statuses.

Messages go to standard error, so that standard output is free for a picture. Nothing heavy is imported before it is
known to be needed: `--help` must not wait for numpy and Dr.Jit, and a wrong argument must not either.
"""

import os
import sys
import time

from renderer import __version__, options as command_line
from renderer.core.errors import (
    EXIT_BAD_INPUT, EXIT_DONE, EXIT_FAILED, EXIT_INTERRUPTED, RenderError, SceneError, UsageError,
)

# Of the picture in all its forms, by (several samples, EXR); 24, 58, 80 and 142 were measured at 4000 x 3000.
BYTES_A_PIXEL = {(False, False): 28, (False, True): 64, (True, False): 88, (True, True): 156}
DOCTOR = "python -m renderer doctor"


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


def _run(arguments, start):
    """Run one command and return its exit status."""
    if arguments and arguments[0] == "doctor":
        from renderer import doctor

        return doctor.main(arguments[1:])
    if arguments and arguments[0] == "schema":
        return _print_schema(arguments[1:])
    if arguments and arguments[0] == "compare":
        from renderer import comparison

        return comparison.main(arguments[1:], _say)
    return _render(command_line.parse(arguments), start)


def _render(options, start):
    """Load, render and write; return the exit status."""
    from renderer.io import outputs
    from renderer.scene import loader

    width, height = options.size or (None, None)
    loaded = loader.load(options.scene, strict=options.strict, mode=options.mode)
    loaded = loader.override(loaded, width=width, height=height, samples=options.samples, nbounces=options.bounces)
    _check_mode(loaded.description, options)
    if options.pixel is not None:
        return _replay(loaded, options)
    paths = options.output or [os.path.splitext(os.path.basename(options.scene))[0] + ".ppm"]
    outputs.check(paths, _inputs(loaded))
    has_exr = any(outputs.is_exr(path) for path in paths)
    _check_memory(loaded.description, options, has_exr)
    _tell_remarks(loaded, options)
    from renderer.interrupt import prompt_interrupt

    with prompt_interrupt() as interrupt:
        rendering = _trace(loaded, options, has_exr, interrupt)
        grading = outputs.Grading(options.tonemap, options.exposure, options.encoding)
        outputs.write_all(paths, rendering, grading, _header(loaded, options, rendering))
    for line in _lost(rendering, options):
        _say(line)
    if not options.quiet:
        _say(_summary(paths, rendering, time.perf_counter() - start))
    if interrupt.asked:
        _say(f"interrupted after {_samples(rendering.samples)} a pixel")
        return EXIT_INTERRUPTED
    return EXIT_DONE


def _tell_remarks(loaded, options):
    """Print what is odd about the scene."""
    for remark in loaded.warnings:
        if not (remark.is_note and options.quiet):
            _say(f"{'note' if remark.is_note else 'warning'}: {remark}")


def _check_mode(description, options):
    """Refuse options that mean nothing in the mode of the render."""
    from renderer.scene import schema

    mode, camera = description.rendermode, description.camera
    for name in ("time", "error", "pixel"):
        if getattr(options, name) is not None and mode not in schema.SAMPLED_MODES:
            raise UsageError(f"--{name}: mode '{mode}' has no samples")
    if options.denoise:
        if mode not in schema.SHADED_MODES:
            raise UsageError(f"--denoise: mode '{mode}' shows no light")
        from renderer import denoise

        denoise.load()
    if options.pixel is not None and not (options.pixel[0] < camera.width and options.pixel[1] < camera.height):
        raise UsageError(f"--pixel: the picture is {camera.width} x {camera.height}, counted from 0")


def _replay(loaded, options):
    """Print the radiance of one sample."""
    _load_engine(options.backend, options.threads)
    from renderer.engine.render import replay

    sample = options.sample or 0
    radiance = replay(loaded, options.pixel, sample, seed=options.seed, accel=options.accel)
    column, row = options.pixel
    values = " ".join(f"{channel:.9g}" for channel in radiance)
    command_line.print_out(f"pixel {column},{row} sample {sample} seed {options.seed}: {values}\n")
    return EXIT_DONE


def _lost(rendering, options):
    """Yield a warning where samples were left out, and the commands that repeat some of them."""
    if rendering.lost is None:
        return
    count, examples = rendering.lost.count, rendering.lost.examples
    yield f"warning: {_samples(count)} of the picture {'was' if count == 1 else 'were'} NaN or infinite, and left out"
    for kind, column, row, sample in examples:
        command = ["python -m renderer", options.scene, f"--pixel {column},{row}"]
        command += [f"--sample {sample} --seed {options.seed}"]
        command += [f"--mode {options.mode}"] if options.mode else []
        command += ["--size {}x{}".format(*options.size)] if options.size else []
        command += [f"--samples {options.samples}"] if options.samples else []
        command += [f"--bounces {options.bounces}"] if options.bounces is not None else []
        yield f"warning: {kind}: {' '.join(command)}"


def _samples(count):
    """Return a number of samples in words."""
    return f"{count} sample{'' if count == 1 else 's'}"


def _check_memory(description, options, has_exr):
    """Refuse a picture that would not fit: the system would end the process without a word."""
    from renderer import machine

    camera, several = description.camera, description.spp > 1 or options.time is not None or options.error is not None
    needed = camera.width * camera.height * BYTES_A_PIXEL[several, has_exr or options.denoise]
    free = machine.available_memory()
    if free is not None and needed > free:
        raise UsageError(
            f"a picture of {camera.width} x {camera.height} needs about {needed / 2**30:.1f} GiB of memory, and "
            f"{free / 2**30:.1f} GiB are free; choose a smaller --size"
        )


def _inputs(loaded):
    """Return the files that the scene is made of, in any mode."""
    from renderer.scene.materials import textures_of

    owners = [*loaded.description.scene.lightsources, *(shape for _, shape in loaded.shapes)]
    names = {getattr(owner, "filename", None) for owner in owners}
    for material in {shape.material for _, shape in loaded.shapes}:
        names |= {source for paths in (False, True) for _, source in textures_of(material, paths)}
    return [loaded.path, *(loaded.resolve(name) for name in names if isinstance(name, str))]


def _trace(loaded, options, variance, interrupt):
    """Return the rendering, with progress told on the way."""
    from renderer.progress import Progress

    render, until = _load_engine(options.backend, options.threads), None
    if options.time is not None or options.error is not None:
        from renderer.engine.passes import Until
        from renderer.scene.schema import MAX_SAMPLES

        until = Until(options.samples or MAX_SAMPLES, options.time, options.error)
    progress = Progress(None if options.quiet else sys.stderr)
    try:
        rendering = render(loaded, seed=options.seed, accel=options.accel, until=until, variance=variance,
                           progress=progress, interrupted=interrupt.after_pass)
    finally:
        progress.close()
    if options.denoise:
        from renderer import denoise

        rendering = denoise.denoised(rendering)
    return rendering


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


def _header(loaded, options, rendering):
    """Return the settings that an EXR carries, as text."""
    from renderer.scene import schema

    description = loaded.description
    exposure = description.camera.exposure if options.exposure is None else options.exposure
    encoding = options.encoding or schema.encoding_of(description.rendermode)
    settings = {
        "version": __version__, "scene": loaded.path, "mode": description.rendermode, "samples": rendering.samples,
        "size": f"{description.camera.width}x{description.camera.height}", "seed": options.seed,
        "nbounces": description.nbounces, "exposure": exposure, "tonemap": options.tonemap or description.tonemap,
        "encoding": encoding,
    }
    return {f"renderer.{name}": str(value) for name, value in settings.items()}


def _summary(paths, rendering, total):
    """Return the line that every run ends with."""
    from renderer.io import outputs

    timings = rendering.timings
    return (
        f"{', '.join(map(outputs.name, paths))}: "
        f"{rendering.width} x {rendering.height}, {rendering.mode}, "
        f"{_samples(rendering.samples)} a pixel; "
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

    command_line.print_out(reference.schema_json().rstrip("\n") + "\n")
    return EXIT_DONE


def _failed(error, status, message=None):
    """Tell what went wrong and return the status."""
    if os.environ.get("RENDERER_DEBUG"):
        import traceback

        _say("".join(traceback.format_exception(error)).rstrip())
    _say(str(error) if message is None else message)
    return status


def _say(text):
    """Print a message to standard error; nobody may be listening."""
    try:
        print(text, file=sys.stderr, flush=True)
    except (OSError, ValueError, AttributeError):  # closed by its reader, or never opened
        pass

"""docs/command-line.md tells what the parser does, no more and no less."""

import re
from pathlib import Path

import pytest

from renderer import __version__, cli, options as command_line
from renderer.core import errors

PAGE = (Path(__file__).parents[2] / "docs" / "command-line.md").read_text()
PARTS = PAGE.split("\n## Comparing pictures\n")
PARSERS = [command_line.build_parser, command_line.build_comparison_parser]
parts_and_parsers = pytest.mark.parametrize("part, parser", list(zip(PARTS, PARSERS)), ids=["render", "compare"])


def rows(part):
    """Return the rows of options of a part of the page."""
    return [line for line in part.splitlines() if line.startswith("| `-")]


def options(parser):
    """Return the parser's actions that have option names."""
    return [action for action in parser()._actions if action.option_strings]


@parts_and_parsers
def test_every_option_has_its_row(part, parser):
    """Names and place holder, in the first column."""
    told = {cell for row in rows(part) for cell in re.findall(r"`([^`]+)`", row.split("|")[1])}
    known = {f"{name} {action.metavar}" if action.metavar else name
             for action in options(parser) for name in action.option_strings}
    assert told == known


@parts_and_parsers
def test_every_choice_is_told(part, parser):
    """Modes, curves, encodings and backends, in the row of their option."""
    for action in options(parser):
        for choice in action.choices or ():
            row, = [row for row in rows(part) if f"`{action.option_strings[-1]} " in row]
            assert f"`{choice}`" in row


def test_every_exit_status_is_told():
    """The table has the statuses of the code."""
    told = {int(number) for number in re.findall(r"^\| (\d+) \|", PAGE, re.MULTILINE)}
    assert told == {getattr(errors, name) for name in vars(errors) if name.startswith("EXIT_")}


def test_every_header_key_is_told(scene, engine):
    """What an EXR carries."""
    import OpenEXR

    assert cli.main([scene, "-o", "x.exr"]) == 0
    keys = {key for key in OpenEXR.File("x.exr").header() if key.startswith("renderer.")}
    assert keys == set(re.findall(r"`(renderer\.[a-z]+)`", PAGE))


def test_backends_are_those_of_the_engine(run_python):
    """The parser keeps a copy of the list, because asking for it would load Dr.Jit."""
    code = "from renderer import options as o; from renderer.core import backend as b; print(b.BACKENDS == o.BACKENDS)"
    assert run_python(code).stdout == "True\n"


def test_structures_are_those_of_the_engine(run_python):
    """A copy for the same reason."""
    code = "from renderer import options as o; from renderer.scene import arrange as a; print(a.STRUCTURES == o.ACCELS)"
    assert run_python(code).stdout == "True\n"


def test_version_is_printed(capfd):
    """`--version` names the program and its version."""
    try:
        cli.main(["--version"])
    except SystemExit as end:
        assert end.code == 0
    assert capfd.readouterr().out == f"renderer {__version__}\n"

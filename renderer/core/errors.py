"""What goes wrong, told in the user's terms: problems with their place in the scene file, and exit statuses."""

from dataclasses import dataclass

EXIT_DONE, EXIT_FAILED, EXIT_BAD_INPUT, EXIT_INTERRUPTED = 0, 1, 2, 130


@dataclass(frozen=True)
class Problem:
    """One mistake or remark: where it is and what is wrong with it.

    `file` is the path as the user wrote it; `line` and `column` count from 1 (0 where unknown);
    `key_path` reads like `scene.shapes[3].radius` and is empty for the file as a whole.
    """

    file: str
    message: str
    key_path: str = ""
    line: int = 0
    column: int = 0
    is_note: bool = False  # said for information: nothing is wrong

    def __str__(self):
        place = f"{self.file}:{self.line}:{self.column}" if self.line else self.file
        return ": ".join(part for part in (place, self.key_path, self.message) if part)


class SceneError(Exception):
    """The scene cannot be rendered as written; `problems` lists every mistake found. Exit status 2."""

    def __init__(self, *problems):
        self.problems = tuple(problems)
        super().__init__("\n".join(map(str, self.problems)))


class UsageError(Exception):
    """A command line, path or setting that cannot be used. Exit status 2."""


class RenderError(Exception):
    """A render that was started and failed: device, memory, or the output file. Exit status 1."""

"""Fixtures that compare our picture of a scene with Mitsuba's: ray by ray, or path traced."""

import pytest

from tests.support import oracle as sides
from tests.support.documents import write_texture
from tests.support.paths import Judge

GEOMETRY = ("shape", "depth", "normal", "uv", "albedo")


@pytest.fixture
def agree(tmp_path):
    """A function that demands agreement of the named pictures (default: geometry and colour) of a scene document."""

    def check(document, names=(*GEOMETRY, "rgb")):
        write_texture(tmp_path / "texture.png")
        camera = document["camera"]
        loaded = sides.prepare(sides.write(tmp_path, document), camera["width"], camera["height"])
        oracle = sides.Oracle(loaded)
        assert oracle.hit.any(), "an empty picture shows nothing"
        return {name: oracle.check(name, sides.observe(loaded, name)) for name in names}

    return check


@pytest.fixture(scope="module")
def judge(tmp_path_factory):
    """Both sides of a module's path-traced cases."""
    return Judge(tmp_path_factory.mktemp("paths"))

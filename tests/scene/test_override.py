"""Settings of the command line in place of the file's."""

import pytest

from renderer.core.errors import UsageError
from renderer.scene.loader import from_dict, override


@pytest.fixture
def loaded(document):
    return from_dict(document)


def test_given_settings_replace_the_files_own(loaded):
    """What is not given stays, and the original is untouched."""
    changed = override(loaded, mode="depth", width=30, samples=4, nbounces=0)
    camera = changed.description.camera
    assert (camera.width, camera.height, camera.position) == (30, 800, (0.0, 0.0, -5.0))
    description = changed.description
    assert (description.rendermode, description.samples, description.nbounces) == ("depth", 4, 0)
    assert loaded.description.camera.width == 1200
    assert changed.shapes == loaded.shapes


def test_nothing_given_changes_nothing(loaded):
    """The description is equal to the old one."""
    assert override(loaded).description == loaded.description


@pytest.mark.parametrize(("settings", "said"), [
    ({"width": 0}, "width: must be between 1 and 65536, got 0"),
    ({"height": -2}, "height: must be between 1 and 65536, got -2"),
    ({"samples": 2**30}, "samples: must be between 1 and 16777216, got 1073741824"),
    ({"nbounces": 65}, "nbounces: must be between 0 and 64, got 65"),
    ({"mode": "phnog"}, "mode: unknown rendermode 'phnog', did you mean 'phong'?"),
    ({"width": 60_000, "height": 60_000}, "width times height must be at most 268,435,456 pixels"),
    ({"width": "30"}, "width: must be a whole number between 1 and 65536, got the text '30'"),
])
def test_an_impossible_setting_is_a_usage_error(loaded, settings, said):
    """The message names the setting, the bounds and the value."""
    with pytest.raises(UsageError) as caught:
        override(loaded, **settings)
    assert said in str(caught.value)


def test_all_impossible_settings_are_told(loaded):
    """One line each."""
    with pytest.raises(UsageError) as caught:
        override(loaded, width=0, samples=0)
    assert len(str(caught.value).splitlines()) == 2

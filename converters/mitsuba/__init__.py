"""Scenes for stock Mitsuba: `to_dict` for code, `write_xml` for files.

Both are written from one tree (`plan`), so that they cannot drift apart.
"""

from converters.mitsuba.plan import plan


def to_dict(loaded, exact=False):
    """Return the dictionary that `mi.load_dict` takes; the warnings are in `plan(loaded).warnings`.

    `exact` uses plugins of our own where stock ones only come near (mode `pathtracer`).

    Sets Mitsuba's variant to llvm_ad_rgb where none was chosen. Raises SceneError where a texture cannot be read.
    """
    from converters.mitsuba.as_dict import scene_dictionary

    return scene_dictionary(plan(loaded, exact))


def write_xml(loaded, path):
    """Write `path` and the folder `<stem>_files` of meshes and images beside it; return the warnings (Problems).

    Needs no Mitsuba. Raises SceneError for unreadable textures and OSError for unwritable files.
    """
    from converters.mitsuba.as_xml import write

    scene = plan(loaded)
    write(scene, path)
    return scene.warnings

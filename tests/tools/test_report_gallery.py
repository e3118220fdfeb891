"""What the report tells of our own scenes."""

from tools.report import gallery, results


def test_time_of_all_samples_is_scaled_up(monkeypatch):
    """A start of a second and half a second a sample: 64 samples take 33 s, told with one digit."""
    monkeypatch.setattr(gallery, "seconds", lambda loaded, samples: 1 + samples / 2)
    monkeypatch.setattr(gallery, "triangles_of", lambda loaded: 12345)
    told = gallery.facts("studio")
    assert told["time"] == f"30{results.THIN}s" and told["triangles"] == "12,345"
    assert (told["samples"], told["bounces"], told["size"]) == ("64", "8", "600 × 400")


def test_pictures_are_those_that_are_handed_in():
    """Each is in TestSuite/, and its scene in scenes/."""
    for scene in gallery.SCENES:
        for path in (f"TestSuite/{scene}.jpg", f"scenes/{scene}.json"):
            assert (results.ROOT / path).exists()

"""Files in and out: pictures written whole or not at all, textures read."""

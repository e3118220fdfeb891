"""The transfer curve of sRGB (IEC 61966-2-1)."""

from __future__ import annotations

import numpy as np


def decoded(values):
    """Return encoded values, 0 to 1, as linear ones."""
    values = np.asarray(values, np.float64)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def encoded(values):
    """Return linear values, 0 to 1, as encoded ones."""
    values = np.asarray(values, np.float64)
    return np.where(values <= 0.0031308, values * 12.92, 1.055 * np.maximum(values, 0.0031308) ** (1 / 2.4) - 0.055)

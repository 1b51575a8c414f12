"""A minimal program that shows the finding beside this file. Needs Mitsuba 3 only; seconds."""

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
mi.set_log_level(mi.LogLevel.Error)


def disk(u: np.ndarray, v: np.ndarray) -> mi.Shape:
    """The ellipse whose conjugate radii are u and v, in the plane z = 0."""
    matrix = np.eye(4)
    matrix[:2, 0], matrix[:2, 1] = u, v
    return mi.load_dict({"type": "disk", "to_world": mi.ScalarTransform4f(matrix)})


print("area of an ellipse by radii whose angle has that sine: by Mitsuba, divided by pi |u x v|")
for sine in (1.0, 0.1, 0.03, 0.01, 0.003, 0.001, 0.0003):
    ratios = []
    for turn in np.linspace(0, 2 * np.pi, 64, endpoint=False):  # the rounding depends on how it lies
        u, v = np.array([1.0, 0.0]), np.array([np.sqrt(1 - sine**2), sine])
        turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        ratios.append(disk(turned @ u, turned @ v).surface_area() / (np.pi * sine))
    print(f"{sine:<7g} {min(ratios):.5f} to {max(ratios):.5f}")

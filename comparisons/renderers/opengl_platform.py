"""pyrender, without a screen: on EGL, or on OSMesa where there is no EGL.

PyOpenGL chooses its platform when it is imported, by an environment variable, so the choice is made here, before.
"""

from __future__ import annotations

import ctypes
import os
import sys
from contextlib import suppress
from importlib.metadata import version
from typing import Any

from packaging.version import Version

from comparisons.renderers import limits
from comparisons.renderers.protocol import RendererFailed

INSTALL = "pip install lightproof[opengl]; on Debian also: apt install libegl1 libgl1 libgl1-mesa-dri"

_PLATFORM = "PYOPENGL_PLATFORM"
_EGL, _GL, _OSMESA = ("libEGL.so.1",), ("libGL.so.1",), ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so")
_OSMESA_NEEDS = Version("3.1.10")


def load() -> Any:
    """The module ``pyrender``, ready to draw.

    Raises:
        ImportError: it is not installed.
        RendererFailed: a library of the system is missing; the message names the Debian package.
    """
    if _PLATFORM not in os.environ:  # who has set it has chosen
        os.environ[_PLATFORM] = platform()
    os.environ.setdefault("LP_NUM_THREADS", "1")  # work is split over processes
    if folder := os.environ.get(limits.MARK):
        # Mesa keeps compiled shaders in files, without which OSMesa compiles one for each surface; with those of the
        # process they go away
        os.environ.setdefault("MESA_SHADER_CACHE_DIR", folder)
    try:
        import pyrender
    except ModuleNotFoundError as error:
        raise ImportError(f"there is no module {error.name}: {INSTALL}") from None
    except ImportError as error:  # PyOpenGL's: its platform has no library, or can't use it
        said = " ".join(map(str, error.args))[:100]
        raise RendererFailed(
            f"{_PLATFORM}={os.environ[_PLATFORM]}: {said}; without that variable it is EGL, or OSMesa where there is "
            "none; on Debian: apt install libegl1 libgl1 libgl1-mesa-dri (or libosmesa6)"
        ) from None
    return pyrender


def platform() -> str:
    """``egl`` or ``osmesa``, whichever this machine has.

    Raises:
        RendererFailed: neither; or OSMesa, and a PyOpenGL that can't use it.
    """
    if not sys.platform.startswith("linux"):
        raise RendererFailed(f"found {sys.platform}: expected Linux, which draws without a screen")
    if _there(_EGL):
        if not _there(_GL):
            raise RendererFailed(f"no {_GL[0]} beside {_EGL[0]}: apt install libgl1 libgl1-mesa-dri")
        return "egl"
    if not _there(_OSMESA):
        raise RendererFailed(
            f"no OpenGL without a screen: neither {_EGL[0]} nor {_OSMESA[0]} is there; on Debian: "
            "apt install libegl1 libgl1 libgl1-mesa-dri (or libosmesa6)"
        )
    if (found := Version(version("PyOpenGL"))) < _OSMESA_NEEDS:
        raise RendererFailed(
            f"OSMesa needs PyOpenGL {_OSMESA_NEEDS} or later, found {found}, the one that pyrender pins: apt install "
            f"libegl1 libgl1 libgl1-mesa-dri, or pip install --no-deps 'PyOpenGL>={_OSMESA_NEEDS}'"
        )
    return "osmesa"


def _there(names: tuple[str, ...]) -> bool:
    for name in names:
        with suppress(OSError):
            ctypes.CDLL(name)
            return True
    return False


def canvas(pyrender: Any) -> Any:
    """An ``OffscreenRenderer`` of one pixel, to be given any size.

    Raises:
        RendererFailed: the libraries are there, a driver is not.
    """
    try:
        return pyrender.OffscreenRenderer(1, 1)
    except Exception as error:
        said = f"{type(error).__name__}: {' '.join(str(error).split())}"[:100]
        raise RendererFailed(
            f"{os.environ[_PLATFORM]} gives no OpenGL context, as without a driver ({said}); on Debian: "
            "apt install libegl-mesa0 libgl1-mesa-dri"
        ) from error

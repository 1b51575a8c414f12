"""Where OpenGL, or what it needs of the system, is missing: it is named, with a way out."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from comparisons.renderers import RendererFailed, opengl_platform
from comparisons.renderers.process import RendererProcess


def test_what_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    there = {"libEGL.so.1": False, "libGL.so.1": True, "libOSMesa.so.8": False}
    monkeypatch.setattr(opengl_platform, "_there", lambda names: there[names[0]])
    with pytest.raises(RendererFailed, match="apt install libegl1 libgl1 libgl1-mesa-dri"):
        opengl_platform.platform()
    there["libOSMesa.so.8"] = True
    monkeypatch.setattr(opengl_platform, "version", lambda package: "3.1.0")
    with pytest.raises(RendererFailed, match=r"OSMesa needs PyOpenGL 3\.1\.10 or later, found 3\.1\.0"):
        opengl_platform.platform()
    monkeypatch.setattr(opengl_platform, "version", lambda package: "3.1.10")
    assert opengl_platform.platform() == "osmesa"
    there |= {"libEGL.so.1": True, "libGL.so.1": False}
    with pytest.raises(RendererFailed, match="no libGL"):
        opengl_platform.platform()
    there["libGL.so.1"] = True
    assert opengl_platform.platform() == "egl"


def test_a_platform_that_is_not_there_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As PyOpenGL says it, with a way out."""
    said = ("Unable to load OpenGL library", "OSMesa: cannot open shared object file", "OSMesa", None)
    (tmp_path / "pyrender.py").write_text(f"raise ImportError(*{said})")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "pyrender", raising=False)
    for name in ("PYOPENGL_PLATFORM", "LP_NUM_THREADS"):
        monkeypatch.setenv(name, "osmesa")
    with pytest.raises(RendererFailed, match=r"=osmesa: Unable to load .*without that variable .*libosmesa6"):
        opengl_platform.load()


def test_a_missing_driver_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The library that chooses among drivers is there, and is told of none."""
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere.json")
    monkeypatch.setenv("PYOPENGL_PLATFORM", "egl")
    with pytest.raises(RendererFailed, match=r"egl gives no OpenGL context.*apt install libegl-mesa0"):
        RendererProcess("pyrender")

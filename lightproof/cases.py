"""What is asked for on the command line: a case of the library, of another package, of a file; or a scene.

A case of one's own needs no change in this package:

- a Python function without arguments that returns a ``scenes.Case``, named ``path/to/file.py:function``;
- the same, announced by an installed package as an entry point of the group ``lightproof.cases``, whose name is
  that of the case;
- a scene as JSON with an answer image: an EXR file with the layers ``bounce0``, ``bounce1``, …, as
  ``lightproof render`` and ``lightproof answer`` write it.
"""

from __future__ import annotations

import importlib.util
import re
import sys
import traceback
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import numpy as np
import typer
from numpy.typing import NDArray

from scenes import Case, Estimate, Formula, Scene, SceneError, Tolerance, UnknownNameError, library
from scenes.formats import exr
from scenes.names import look_up

Images = NDArray[np.float64]

GROUP = "lightproof.cases"
OWN_TOLERANCE = Tolerance(image=(0.01,), tile=(0.05,))
"""Of a scene with an answer image, unless told otherwise."""

_STANDARD_ERRORS = 6.0
"""How far below 0 the noise of an answer may reach: of 10⁹ pixels one."""

_NARROW = 1.0
"""Degrees. No camera has so narrow a view, but many have one of less than 1 rad."""

_EXAMPLE = "such as my_cases.py:my_case"
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")


class CaseError(ValueError):
    """A case that can't be had; its message says what to do."""


def announced() -> dict[str, EntryPoint]:
    """The cases of installed packages, by name. A name that the library has stays the library's."""
    return {point.name: point for point in entry_points(group=GROUP) if point.name not in library.CASES}


def find(name: str) -> Case:
    """The case of that name, of the library or of an installed package; or of a file, ``file.py:function``.

    Raises:
        UnknownNameError: nothing is called that.
        CaseError: it can't be made.
    """
    if ".py:" in name:
        return from_file(name)
    if name in library.CASES:
        return library.case(name)
    others = announced()
    if name in others:
        return from_entry_point(others[name])
    if Path(name).suffix or Path(name).name != name:
        raise CaseError(f"{name}: expected the name of a case, a scene FILE.json, or a function FILE.py:NAME")
    raise UnknownNameError("case", name, [*library.CASES, *others])


def from_file(place: str) -> Case:
    """The case that ``path/to/file.py:function`` makes.

    Raises:
        CaseError: there is no such file or function, it raises, or what it returns is no case.
    """
    file, _, function = place.rpartition(":")
    path = Path(file)
    if path.suffix != ".py" or not function.isidentifier():
        raise CaseError(f"{place}: expected a file and a function in it, {_EXAMPLE}")
    if not path.is_file():
        raise CaseError(f"{path}: there is no such file")
    spec = importlib.util.spec_from_file_location(f"lightproof_case_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[module.__name__] = module  # as an import does; dataclasses look it up there
    sys.path.append(str(path.resolve().parent))  # for the file's own imports of its neighbours
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise CaseError(f"{path} can't be imported: {_described(error)}") from error
    own = {
        name: value
        for name, value in vars(module).items()
        if callable(value) and getattr(value, "__module__", None) == module.__name__
    }
    try:
        make = getattr(module, function, None) or look_up("function", function, own)
    except UnknownNameError as error:
        raise CaseError(f"{path}: {error}") from None
    return _made(make, place)


def from_entry_point(point: EntryPoint) -> Case:
    """The case that an entry point makes.

    Raises:
        CaseError: it can't be loaded, it raises, or what it returns is no case.
    """
    package = point.dist.name if point.dist else "an unknown package"
    place = f"{point.name} = {point.value} of {package}"
    try:
        make = point.load()
    except Exception as error:
        raise CaseError(f"{place} can't be loaded: {_described(error)}") from error
    case = _made(make, place)
    if case.name != point.name:
        raise CaseError(
            f"{place} makes a case called {case.name}; entry point and case must have the same name"
        )
    return case


def from_answer(scene: Path, answer: Path) -> Case:
    """A scene with an answer image.

    Its name is that of the scene's file. It holds for as many bounces as the image has layers.

    Raises:
        CaseError: one of the files can't be read, or they don't fit.
    """
    found = load_scene(scene)
    try:
        mean, stderr = exr.read_bounces(answer)
        source = exr.read_attribute(answer, "lightproof:source")
        wavelengths = exr.read_wavelengths(answer)
    except exr.ImageError as error:
        raise CaseError(str(error)) from None
    if mean.shape[1:] != found.shape:
        raise CaseError(
            f"{answer} has (height, width, channels) = {mean.shape[1:]}, the scene's sensor has {found.shape}"
        )
    _check_radiance(mean, stderr, f"{answer}")
    last = len(mean) - 1
    return Case(
        name=checked_name(scene.stem, f"{scene}"),
        family="own",
        title=f"{scene.name} with the answer {answer.name}",
        scene=found,
        # an absolute path stays what it is
        answer=Estimate(str(answer.resolve()), kind="estimated" if stderr.any() else "computed"),
        bounces=last,
        max_bounces=last,
        tolerance=OWN_TOLERANCE,
        derivation=f"The answer is the image {answer.name}. {source}".strip(),
        blind_to="an error that the answer image shares",
        wavelengths=wavelengths,
    )


def _check_radiance(mean: Images, stderr: Images, place: str) -> None:
    """Refuse what no answer can be. By its noise, or by the rounding of 32 bits, it may lie below 0.

    Raises:
        CaseError: naming the first pixel.
    """
    allowed = 1e-6 * np.abs(mean[np.isfinite(mean)]).max(initial=0.0) + _STANDARD_ERRORS * stderr
    wrong = ~(np.isfinite(mean) & np.isfinite(stderr) & (stderr >= 0) & (mean >= -allowed))
    if wrong.any():
        k, y, x, c = np.argwhere(wrong)[0]
        error = f" with a standard error of {stderr[k, y, x, c]:g}" if stderr[k, y, x, c] != 0 else ""
        raise CaseError(
            f"{place} is {mean[k, y, x, c]:g}{error} in bounce {k}, row {y}, column {x}, channel {c}: expected "
            "finite radiance ≥ 0, as far as its standard error can tell"
        )


def load_scene(path: Path) -> Scene:
    """A scene from a JSON file. An angle of view that looks like radians is warned of.

    Raises:
        CaseError: no such file, or no scene in it.
    """
    try:
        scene = Scene.load(path)
    except OSError as error:
        raise CaseError(f"{path}: {error.strerror}") from None
    except SceneError as error:
        raise CaseError(f"{path}: {error}") from None
    fov = getattr(scene.sensor, "fov", None)
    if fov is not None and fov < _NARROW:
        meant = f"{np.degrees(fov):.3g} if radians were meant"
        typer.echo(f"Warning: {path}: sensor.fov = {fov:g} is in degrees; {meant}", err=True)
    return scene


def check_answer(case: Case, bounces: int, size: tuple[int, int] | None) -> None:
    """Refuse a resolution for which an answer image of the user's says nothing.

    Raises:
        CaseError: naming the resolution it has.
    """
    if not isinstance(case.answer, Estimate) or not Path(case.answer.file).is_absolute():
        return  # a formula holds for all; the library's own data is estimated anew where it does not do
    if case.answer.truth(case.scene.resized(*size) if size else case.scene, bounces) is None:
        mean, _ = exr.read_bounces(case.answer.path)
        _, height, width, _ = mean.shape
        wanted = "x".join(map(str, size or case.scene.shape[1::-1]))
        raise CaseError(
            f"{case.answer.path.name} has {width}x{height} pixels and bounces 0 to {len(mean) - 1}; it says nothing "
            f"of {wanted} and bounce {bounces}"
        )


def _made(make: Callable[[], Any], place: str) -> Case:
    if not callable(make):
        raise CaseError(f"{place} is a {type(make).__name__}: expected a function that returns a Case")
    try:
        case = make()
    except Exception as error:
        raise CaseError(f"{place} raised {_described(error)}") from error
    if not isinstance(case, Case):
        raise CaseError(f"{place} returned a {type(case).__name__}: expected a scenes.Case")
    checked_name(case.name, place)
    if not isinstance(case.answer, Formula):
        return case
    evaluate = partial(_evaluated, case.answer.evaluate, place)
    return replace(case, answer=replace(case.answer, evaluate=evaluate))


def _evaluated(evaluate: Callable[[Scene, int], Any], place: str, scene: Scene, bounces: int) -> Images:
    """The answer of someone else's case, which may be wrong in more ways than one of the library.

    Raises:
        CaseError: it raises, or what it returns is no image of radiance for every bounce.
    """
    try:
        images = np.asarray(evaluate(scene, bounces), dtype=np.float64)
    except Exception as error:
        call = f"evaluate(scene, bounces={bounces})"
        raise CaseError(f"{place}: {call} of its answer raised {_described(error)}") from error
    expected = (bounces + 1, *scene.shape)
    if images.shape != expected:
        raise CaseError(
            f"{place}: its answer has the shape {images.shape}: expected (bounces + 1, height, width, channels) = "
            f"{expected}"
        )
    rounding = 1e-9 * np.abs(images[np.isfinite(images)]).max(initial=0.0)
    wrong = ~(np.isfinite(images) & (images >= -rounding))
    if wrong.any():
        k, y, x, c = np.argwhere(wrong)[0]
        raise CaseError(
            f"{place}: its answer is {images[k, y, x, c]:g} in bounce {k}, row {y}, column {x}, channel {c}: "
            "expected finite radiance ≥ 0"
        )
    return images


def checked_name(name: str, place: str) -> str:
    """The name, fit for those of folders and files.

    Raises:
        CaseError: it has other characters.
    """
    if not _NAME.fullmatch(name):
        raise CaseError(
            f"{place}: the name {name!r} has other characters than letters, digits, '.', '_' and '-'"
        )
    return name


def _described(error: BaseException) -> str:
    """What was raised, and where: the line that is reached last in the file of the function that was called."""
    frames = [
        f for f in traceback.extract_tb(error.__traceback__)[1:] if not f.filename.startswith("<frozen")
    ]
    lines = [frame.lineno for frame in frames if frame.filename == frames[0].filename]
    where = f" ({Path(frames[0].filename).name}, line {lines[-1]})" if lines else ""
    return f"{type(error).__name__}: {error}{where}"

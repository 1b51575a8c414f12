"""A small reader of pbrt-v4's text, with its conventions: what stands there, in which transformation and state.

It stops where pbrt would: at unknown parameters, directives out of place, names that are taken or not yet made.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

TOKEN = re.compile(r'#[^\n]*|"[^"]*"|\[|\]|[^\s\[\]"]+')


METALS = {"spectrum eta", "spectrum k", "float roughness", "bool remaproughness"}
KNOWN: dict[tuple[str, str], set[str]] = {
    ("Camera", "perspective"): {"float fov", "float lensradius", "float focaldistance"},
    ("Camera", "orthographic"): {"float screenwindow"},
    ("Film", "rgb"): {"integer xresolution", "integer yresolution", "string filename", "bool savefp16"},
    ("PixelFilter", "box"): {"float xradius", "float yradius"},
    ("Sampler", "independent"): {"integer pixelsamples"},
    ("Integrator", "path"): {"integer maxdepth"},
    ("Material", "diffuse"): {"rgb reflectance"},
    ("Material", "dielectric"): {"float eta", "float roughness", "bool remaproughness"},
    ("Material", "conductor"): METALS,
    ("Material", "mix"): {"string materials", "float amount"},
    ("AreaLightSource", "diffuse"): {"rgb L", "bool twosided"},
    ("LightSource", "point"): {"point3 from", "rgb I"},
    ("LightSource", "spot"): {"point3 from", "point3 to", "float coneangle", "float conedeltaangle", "rgb I"},
    ("LightSource", "distant"): {"point3 from", "point3 to", "rgb L"},
    ("LightSource", "infinite"): {"rgb L"},
    ("Shape", "trianglemesh"): {"point3 P", "integer indices"},
    ("Shape", "plymesh"): {"string filename"},
    ("Shape", "disk"): {"float radius"},
    ("Shape", "sphere"): {"float radius"},
}
"""Directive and type → the parameters of pbrt-v4's file format that are used, with their types."""


@dataclass
class Read:
    """A directive with what held where it stood."""

    name: str
    types: list[str]
    parameters: dict[str, Any]
    matrix: Any
    state: dict[str, Any] = field(default_factory=dict)


@dataclass
class Directive:
    """A name and all that follows it."""

    name: str
    numbers: list[float] = field(default_factory=list)
    types: list[str] = field(default_factory=list)
    parameters: dict[str, Any] = field(default_factory=dict)


def parse(text: str) -> list[Directive]:
    tokens = iter([t for t in TOKEN.findall(text) if not t.startswith("#")])
    found: list[Directive] = []
    for token in tokens:
        if re.fullmatch(r"[A-Z][A-Za-z]+", token):
            found.append(Directive(token))
        elif token.startswith('"') and " " in token:
            assert next(tokens) == "["
            found[-1].parameters[token.strip('"')] = [value(t) for t in iter(lambda: next(tokens), "]")]
        elif token.startswith('"'):
            found[-1].types.append(token.strip('"'))
        elif token not in "[]":
            found[-1].numbers.append(float(token))
    return found


def read(text: str) -> list[Read]:
    """Directives that make something, with the transformation and the state that held there."""
    found: list[Read] = []
    matrix, state, stack = np.eye(4), dict[str, Any](), list[Any]()
    for d in parse(text):
        match d.name:
            case "Transform":
                matrix = np.reshape(d.numbers, (4, 4)).T
            case "Scale":
                matrix = matrix @ np.diag([*d.numbers, 1])
            case "LookAt":
                matrix = matrix @ look_at(*np.reshape(d.numbers, (3, 3)))
            case "WorldBegin":
                matrix, state = np.eye(4), {}
            case "AttributeBegin":
                stack.append((matrix, state))
            case "AttributeEnd":
                matrix, state = stack.pop()
            case "ReverseOrientation":
                state = state | {"reversed": not state.get("reversed", False)}
            case _:
                made = Read(d.name, d.types, d.parameters, matrix, state)
                found.append(made)
                # a named material under its name, the others under that of their directive
                state = state | {d.types[0] if d.name == "MakeNamedMaterial" else d.name: made}
    assert not stack
    check(found)
    return found


def check(found: list[Read]) -> None:
    """What pbrt would stop at: unknown parameters, directives out of place, a name that is taken or not yet made."""
    options = ["Camera", "Film", "PixelFilter", "Sampler", "Integrator"]
    assert [r.name for r in found[:5]] == options
    assert not {r.name for r in found[5:]} & set(options)
    named: list[str] = []
    for r in found:
        [type] = r.types
        if r.name == "MakeNamedMaterial":
            assert type not in named, "named materials are global"
            named.append(type)
            [type] = r.parameters["string type"]
        key = "Material" if r.name == "MakeNamedMaterial" else r.name
        assert set(r.parameters) - {"string type"} <= KNOWN[key, type]
        assert set(r.parameters.get("string materials", ())) <= set(named)


def value(token: str) -> Any:
    if token in ("true", "false"):
        return token == "true"
    return token.strip('"') if token.startswith('"') else float(token)


def look_at(eye: Any, target: Any, up: Any) -> Any:
    """World to camera; pbrt's camera has x = up × view, left-handed."""
    view = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(up / np.linalg.norm(up), view)
    right /= np.linalg.norm(right)
    camera = np.eye(4)
    camera[:3] = np.stack([right, np.cross(view, right), view, eye], axis=1)
    return np.linalg.inv(camera)

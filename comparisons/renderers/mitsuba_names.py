"""Every form of Mitsuba 3 by its name: ``mitsuba[:VARIANT[:INTEGRATOR[:SAMPLER]]]``.

What is left out is ``scalar_rgb``, ``path`` and ``independent``, and the full name leaves them out again where
nothing else follows: ``mitsuba:scalar_rgb:path:independent`` is ``mitsuba:scalar_rgb``. Nothing here imports Mitsuba.
"""

from __future__ import annotations

from typing import NamedTuple

from comparisons.renderers.entry import Entry
from scenes.names import UnknownNameError

FAMILY = "mitsuba"

VARIANTS = {
    "scalar_rgb": "one path after the other, colour as three numbers",
    "llvm_ad_rgb": "compiled for all paths at once, by LLVM",
    "scalar_spectral": "four wavelengths a path",
}
INTEGRATORS = {
    "path": "next event and chance, weighted",
    "volpath": "the same, for scenes with media",
    "volpathmis": "the same, weighted per channel",
    "prb": "path replay backpropagation",
    "ptracer": "particles from the lights, splatted",
    "direct": "emission and direct light alone",
}
SAMPLERS = {
    "independent": "independent numbers",
    "stratified": "stratified, shuffled per dimension",
    "multijitter": "correlated multi-jittered",
    "orthogonal": "orthogonal arrays",
    "ldsampler": "a scrambled (0, 2)-sequence, shuffled per dimension",
}
_PARTS = {"variant": VARIANTS, "integrator": INTEGRATORS, "sampler": SAMPLERS}


LAST_BOUNCE = {"direct": 1}
"""Of integrators that don't go on for ever."""

_TOGETHER = {"stratified": 16, "multijitter": 16, "orthogonal": 25, "ldsampler": 16}
_COMPILED, _COMPILED_PARTICLES = 4, 16


class FormError(UnknownNameError):
    """A form of Mitsuba that there is not; says what there is."""

    def __init__(self, message: str) -> None:
        LookupError.__init__(self, message)
        self._message = message


class Form(NamedTuple):
    """What Mitsuba is run as."""

    variant: str = "scalar_rgb"
    integrator: str = "path"
    sampler: str = "independent"

    @property
    def compiled(self) -> bool:
        """Whether the variant computes all paths at once, by Dr.Jit."""
        return not self.variant.startswith("scalar")

    @property
    def spectral(self) -> bool:
        """Whether the variant computes with wavelengths."""
        return self.variant.endswith("spectral")

    @property
    def coupled(self) -> bool:
        """Whether two depths, rendered with the same seed, share their paths."""
        return self.compiled or (
            self.integrator != "ptracer" and self.sampler in {"independent", "ldsampler"}
        )

    @property
    def spp_unit(self) -> int:
        """Samples per pixel come in multiples of this; see ``mitsuba_samplers``."""
        if self.sampler in _TOGETHER:
            return _TOGETHER[self.sampler]
        if self.compiled:
            return _COMPILED_PARTICLES if self.integrator == "ptracer" else _COMPILED
        return 1

    @property
    def name(self) -> str:
        """The full name: ``mitsuba:llvm_ad_rgb:path:ldsampler``, without the defaults at its end."""
        parts, defaults = list(self), list(Form())
        while len(parts) > 1 and parts[-1] == defaults[-1]:
            parts.pop(), defaults.pop()
        return ":".join([FAMILY, *parts])

    @property
    def spelled_out(self) -> str:
        """All four parts, whatever the defaults."""
        return ":".join([FAMILY, *self])

    @property
    def title(self) -> str:
        """One line."""
        title = f"Mitsuba 3, integrator {self.integrator}: {INTEGRATORS[self.integrator]}"
        if self.variant != "scalar_rgb":
            title += f"; {VARIANTS[self.variant]}"
        return title if self.sampler == "independent" else f"{title}; sampler: {SAMPLERS[self.sampler]}"


def is_of_family(name: str) -> bool:
    """Whether a name speaks of Mitsuba, in whatever form."""
    return name.split(":")[0] == FAMILY


def parse(name: str) -> Form:
    """The form that a name of the family means.

    Raises:
        FormError: there is no such variant, integrator or sampler, or they don't go together.
    """
    family, *parts = name.split(":")
    assert family == FAMILY
    if len(parts) > len(_PARTS):
        raise FormError(f"{name}: expected {FAMILY}:VARIANT:INTEGRATOR:SAMPLER, and nothing more")
    for part, (kind, known) in zip(parts, _PARTS.items(), strict=False):
        if part not in known:
            raise FormError(
                f"no renderer is called {name!r}: there is no {kind} {part!r}, but {', '.join(known)}{_meant(part)}"
            )
    form = Form(*parts)
    if form.integrator == "prb" and not form.compiled:
        works = form._replace(variant="llvm_ad_rgb").name
        raise FormError(f"{name}: prb needs a variant that Dr.Jit compiles, such as {works}")
    return form


def _meant(part: str) -> str:
    """What is to be written for a part that stands in another's place."""
    if part in INTEGRATORS:
        variant = "llvm_ad_rgb" if part == "prb" else "scalar_rgb"
        return f"; the integrator {part} is {Form(variant, part).spelled_out.rpartition(':')[0]}"
    if part in SAMPLERS:
        return f"; the sampler {part} is {Form(sampler=part).spelled_out}"
    return ""


def entry_of(name: str) -> Entry | None:
    """What is known of a form of Mitsuba before it is loaded; None for a name that is none of the family.

    Raises:
        FormError: see ``parse``.
    """
    if not is_of_family(name):
        return None
    form = parse(name)
    return Entry(
        form.title,
        "mitsuba",
        "MitsubaRenderer",
        ":".join(form),
        FAMILY,
        last_bounce=LAST_BOUNCE.get(form.integrator),
        spp_unit=form.spp_unit,
        differences=not form.coupled,
    )


def full_name(name: str) -> str:
    """The full name of a form, by any of its names; any other name is left as it is.

    Raises:
        FormError: see ``parse``.
    """
    return parse(name).name if is_of_family(name) else name


def spelled_out(name: str) -> str:
    """The name of a form with all of its four parts; any other name is left as it is.

    Raises:
        FormError: see ``parse``.
    """
    return parse(name).spelled_out if is_of_family(name) else name


def shown() -> tuple[Form, ...]:
    """The forms that are worth a line in a list: each integrator in each variant, and each sampler with ``path``."""
    forms = [Form(v, i) for v in VARIANTS for i in INTEGRATORS if i != "prb" or not v.startswith("scalar")]
    return (*forms, *(Form(v, "path", s) for v in VARIANTS for s in SAMPLERS if s != "independent"))


def shown_names() -> tuple[str, ...]:
    """Their full names."""
    return tuple(form.name for form in shown())

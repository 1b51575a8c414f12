"""The tracer to read: NumPy, float64, in the order of the mathematics. Only Sobol' points and the finite elements
need SciPy.

    operators.py         L = E + TE + T²E + …, T = R G, as written: start here
    propagation.py       G: the ray-cast function            shapes/    what rays meet, and how
    reflection.py        R: the BSDF of a scene              bsdfs/     one file per kind of material
    emission.py          E, and next event                   emitters/  one file per kind of light
    sensing.py           rays of a sensor, sums on its film
    sampling.py          warps of the unit square, each with its density; random streams
    samplers.py          where random numbers come from: independent, or scrambled Sobol' points
    random_walk.py       all TᵏE from one walk: the fast form
    roulette.py          how a walk without a last bounce ends, for the whole sum

    finite_elements.py   all TᵏE of a diffuse scene of quads as matrix products, without noise
    precomputed_transfer.py   the same under distant light, linear in its spherical harmonics
    elements/            their meshes, bases, form factors and pixel averages

``points.py`` is what travels between them: blocks of points of surfaces. ``vectors.py`` has products and lengths of
vectors. ``arguments.py`` refuses what callers may mistake. What can be rendered: docs/scenes.md.
"""

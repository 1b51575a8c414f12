"""The tracer to read: NumPy only, float64, in the order of the mathematics.

operators.py     L = E + TE + T²E + …, T = R G, as written: start here
propagation.py   G: ray casting
reflection.py    R: BSDFs
emission.py      E: emitters
random_walk.py   all TᵏE from one walk: the fast form
finite_elements.py   all TᵏE of a diffuse scene of quads as matrix products: without noise
precomputed_transfer.py   the same under distant light, as a linear map of its spherical harmonics
"""

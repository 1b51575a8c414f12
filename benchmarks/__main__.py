"""The command; see the package."""

from __future__ import annotations

import os

# one core per side: these are read once, when the libraries behind NumPy load
for _library in ("OMP", "OPENBLAS", "MKL", "VECLIB_MAXIMUM", "NUMEXPR"):
    os.environ[f"{_library}_NUM_THREADS"] = "1"

if __name__ == "__main__":
    from benchmarks.command import main

    raise SystemExit(main())

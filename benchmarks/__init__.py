"""How fast: the tracer beside Mitsuba 3, processes, finite elements; not shipped, and nothing imports it.

python -m benchmarks                 the table; exit code 1 if a row is below what it must reach
python -m benchmarks --json          the same for programs
python -m benchmarks --scaling       nanoseconds per path over shapes, spp, bounces, channels
"""

"""Are the verdicts what they say? ``make calibrate``, or ``python -m benchmarks.calibration``.

The rates of wrong verdicts where they are likeliest, with the bias exactly at the limit of the tolerance; the
power at the bias that a run says it could detect; what a minute resolves; how long the default run takes.

    noise.py       noise of replicates: normal, skewed, fireflies, heavy tails
    simulated.py   verdicts on noise that was drawn from these
    real.py        whole comparisons of real renders, with a truth that is off by just so much
    mitsuba.py     resolution of a minute, duration of the default run
    rates.py, limits.py   counts and figures against what was promised
"""

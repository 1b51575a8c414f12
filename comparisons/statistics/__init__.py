"""The statistics of verdicts: pure mathematics, no renderer in sight."""

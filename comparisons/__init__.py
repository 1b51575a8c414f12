"""Is the renderer right? Renderers, statistics, verdicts, and runs of many comparisons."""

"""Lightproof proves a renderer's light transport right, bounce by bounce."""

from importlib.metadata import version

__version__ = version("lightproof")

"""Shapes, the ground of G: where rays meet them, and what is known there."""

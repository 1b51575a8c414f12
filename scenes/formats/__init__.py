"""Scenes and answers as files for other programs."""

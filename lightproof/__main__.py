"""``python -m lightproof`` is the command ``lightproof``."""

from lightproof.cli import main

main()

"""``python -m kinestitch``: the same as the command ``kinestitch``."""

import sys

from kinestitch.cli import main

if __name__ == "__main__":
    sys.exit(main())

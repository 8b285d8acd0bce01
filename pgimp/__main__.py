"""``python -m pgimp`` is the command ``pgimp``."""

import sys

from pgimp.cli import main

sys.exit(main())

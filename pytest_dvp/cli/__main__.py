"""`python -m pytest_dvp.cli` is `dvp`."""

import sys

from pytest_dvp.cli import main

sys.exit(main())

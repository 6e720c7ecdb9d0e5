"""`python -m pytest_dvp.cli` is `dvp`."""

import sys

from pytest_dvp.cli.command_line import main

sys.exit(main())

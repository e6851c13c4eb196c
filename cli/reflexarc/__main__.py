"""`python -m reflexarc`."""

import sys

from reflexarc.main import main

sys.exit(main())

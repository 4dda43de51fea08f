"""What every test relies on."""

from __future__ import annotations

import signal

from icd_envs.rendering import choose_backend

# A shell that starts the tests in the background ignores SIGINT, and what they start would inherit
# that: the tests that interrupt a run need it to be heard.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Test files may import MuJoCo before any environment does, which would settle for a display.
choose_backend()

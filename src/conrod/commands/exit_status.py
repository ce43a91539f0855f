"""Exit statuses of the command line."""

from __future__ import annotations

FAILED, USAGE, INTERRUPTED = 1, 2, 130

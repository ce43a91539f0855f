"""Published figures against the exact motion: every printed number that a mechanism determines, with a verdict."""

from __future__ import annotations

from conrod.audit.auditing import DOCUMENTS, TITLES, audit, count
from conrod.audit.verdict import Kind, Verdict

__all__ = ["DOCUMENTS", "TITLES", "Kind", "Verdict", "audit", "count"]

"""Published figures against the exact motion: every printed number that a mechanism determines, with a verdict."""

from __future__ import annotations

from conrod.audit.audited import Audited
from conrod.audit.auditing import DOCUMENTS, PAGES, TITLES, audit, audited, count
from conrod.audit.verdict import Kind, Verdict

__all__ = ["DOCUMENTS", "PAGES", "TITLES", "Audited", "Kind", "Verdict", "audit", "audited", "count"]

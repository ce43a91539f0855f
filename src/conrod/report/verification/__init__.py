"""Verification reports: what an engineer signs, in the terms of the standards (docs/verification.md)."""

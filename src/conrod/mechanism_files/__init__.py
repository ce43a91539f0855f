"""Mechanisms as files: TOML, read into checked data and made into scenes (docs/mechanism-files.md)."""

from __future__ import annotations

from conrod.mechanism_files.described_scene import DescribedScene, read_scene, scene_of

__all__ = ["DescribedScene", "read_scene", "scene_of"]

"""The installation checked: versions, engines, and whether wrong runs are noticed here."""

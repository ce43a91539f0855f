"""The description of a machine: links, joints, cams, loads and units; mechanism files."""

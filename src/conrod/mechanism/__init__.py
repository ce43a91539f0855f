"""What a machine is: links, joints, cams, loads and units; mechanism files."""

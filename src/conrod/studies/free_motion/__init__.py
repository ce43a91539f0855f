"""Motion without a drive, judged by the equations of motion."""

"""Report of drive torque, joint reactions and contact force."""

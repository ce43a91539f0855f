"""The report on drive torque, joint reactions and contact force."""

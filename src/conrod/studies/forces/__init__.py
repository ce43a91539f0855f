"""Drive torque, joint reactions and contact force of engines against the exact ones."""

"""Validation of the drive torque, joint reactions and contact force that engines report."""

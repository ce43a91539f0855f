"""Forces that engines report, judged by the exact ones."""

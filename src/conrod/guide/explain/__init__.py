"""Words of conrod explained: outcomes, verdicts, presets, rules, quantities, columns and terms."""

"""Commands that learn and measure: train, export, evaluate, study."""

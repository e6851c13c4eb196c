"""What a training run is made of: its configuration, the presets, the order of its worlds."""

"""What defines a training run: its configuration, the presets, the worlds to learn in."""

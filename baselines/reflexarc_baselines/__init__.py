"""The field's own history: earlier ways to avoid obstacles, each one small module."""

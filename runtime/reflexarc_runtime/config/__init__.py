"""Configuration: a mapping or TOML file becomes a frozen dataclass; errors name their line."""

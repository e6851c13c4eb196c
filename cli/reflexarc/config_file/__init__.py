"""The TOML file with the flags of a command: read, laid under the command line, printed."""

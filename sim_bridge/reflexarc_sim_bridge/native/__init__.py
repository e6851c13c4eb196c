"""Compilation to machine code: decorators, cache, pointers, intrinsics. See README.md."""

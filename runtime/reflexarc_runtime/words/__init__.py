"""Words from outside: how names are shown, and how commands with them are pasted."""

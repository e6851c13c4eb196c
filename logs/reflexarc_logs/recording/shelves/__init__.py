"""The files of recordings: how they are named in a folder, and which make room for newer ones."""

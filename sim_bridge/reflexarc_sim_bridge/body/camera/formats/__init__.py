"""What the bytes of an image file say of it, before anything is decoded."""

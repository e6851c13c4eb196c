"""How messages become chunks: put together, compressed, with the schemas that explain them."""

"""The kinds of layers as compiled code draws them; each has its namesake in `worlds/kinds`."""

"""What a person should hear of a loop: refused inputs, a sensor that is too slow, a flood."""

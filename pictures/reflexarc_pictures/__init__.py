"""SHOWS: pictures and films of logs, worlds and measurements. The only room that draws."""

"""Many ticks compared at once, where nothing about them needs to be looked at one by one."""

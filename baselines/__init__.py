"""One agent per module, all played through the same harness."""

"""One file a study: an experiment repeated while something varies."""

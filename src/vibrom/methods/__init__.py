"""One file a method: a frozen dataclass of its settings whose `fit(training)` gives the Rom."""

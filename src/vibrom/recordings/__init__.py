"""Recorded motions: read from files, resampled, filtered, and made into states."""

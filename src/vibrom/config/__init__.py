"""The configuration: one declaration of each setting, read, merged and checked."""

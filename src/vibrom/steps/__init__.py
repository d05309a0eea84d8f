"""One file a step of the workflow: paths in, paths out. Only steps open and write artefacts."""

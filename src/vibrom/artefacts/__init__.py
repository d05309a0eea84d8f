"""What crosses from one rule to the next: datasets, where they came from, and how a job tells of
its progress.
"""

import os

# Artefacts are replaced whole and never written to: one that another program holds open can be
# read, also where a file system knows no locks. HDF5 looks at this when it is loaded.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")

"""Machine code behind one door: lanes, banded and block solvers. Nothing else imports llvmlite."""

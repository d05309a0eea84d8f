"""What is fast, against named rivals: `python -m benchmarks` runs all, `python -m benchmarks <name>
...` some.
"""

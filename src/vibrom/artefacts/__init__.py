"""What crosses from one rule to the next: datasets, where they came from, and how a job tells of
its progress.
"""

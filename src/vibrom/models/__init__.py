"""What is asked and what answers: the full order and reduced models, their outcomes and the numbers
that compare them.
"""

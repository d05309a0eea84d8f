"""What a user would write today, correct and idiomatic."""

"""Turns what stages can be asked into commands, and is what a question is handed."""

"""The command line: a module for commands of one purpose, and what they share (`options`)."""

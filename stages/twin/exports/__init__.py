"""The twin for other programs; `formats` is the register."""

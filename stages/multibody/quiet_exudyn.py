"""Exudyn, loaded so that it opens no window, prints nothing and reads no settings from the user's home folder."""

from __future__ import annotations

import os

os.environ.setdefault("EXUDYN_NO_USER_SETTINGS", "1")  # such settings would make runs differ between machines

import exudyn

exudyn.config.printToConsole = False
exudyn.special.userInterface.SuppressAll(True)  # its renderer aborts a process that has no display

__all__ = ["exudyn"]

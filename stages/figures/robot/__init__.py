"""Drawings of the twin from its bill of parts: bodies, poses, views, sections."""

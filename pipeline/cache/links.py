"""Artefacts of strangers: an HDF5 file can hold links, to itself in a circle or to other files, which ours never do."""

from __future__ import annotations

import io
from typing import Any

import h5py

from pipeline.errors import ArtefactError


def check(content: bytes, name: str) -> None:
    """Raises `ArtefactError` if a group or dataset in an artefact's bytes is reached by more than one plain link."""
    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            links: list[tuple[str, Any]] = []
            file.visititems_links(lambda path, link: links.append((path, link)))
            for path, link in links:
                if not isinstance(link, h5py.HardLink):
                    raise ArtefactError(f"{name}: {path} is a link to another place; artefacts have none")
            items = {h5py.h5o.get_info(file[path].id).addr for path, _ in links} | {h5py.h5o.get_info(file.id).addr}
    except (OSError, RuntimeError, KeyError, ValueError):
        return  # whoever reads it says what is wrong
    if len(items) != len(links) + 1:
        raise ArtefactError(f"{name}: its groups lie in each other; those of artefacts do not")

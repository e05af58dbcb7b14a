"""Parameters of a study with other values, each put where a field of its name is."""

import dataclasses


def changed(whole, **values):
    """A dataclass of sections with these values: in its own fields, in its settings, or in the one section that has
    such a field.
    """
    parts = {field.name: getattr(whole, field.name) for field in dataclasses.fields(whole)}
    for name, value in values.items():
        if name in parts:
            parts[name] = value
        else:
            owners = [key for key, part in parts.items() if dataclasses.is_dataclass(part) and hasattr(part, name)]
            (owner,) = ["settings"] if "settings" in owners else owners
            parts[owner] = dataclasses.replace(parts[owner], **{name: value})
    return dataclasses.replace(whole, **parts)

from types import SimpleNamespace

NAMES = ("one", "two")


def inputs_of(name):
    return {"one": ("bounce",), "two": ("side",)}[name]


def draw(name, parameters, results):
    content = {"one": lambda: b"%.4g" % results["bounce"].force, "two": lambda: results["side"].read_bytes()}[name]()
    caption = SimpleNamespace(text=f"{parameters.settings.title}: {name}")
    return SimpleNamespace(files={f"figures/{name}.svg": content}, caption=caption)

from types import SimpleNamespace

FIGURES = {"one": SimpleNamespace(inputs=("bounce",)), "two": SimpleNamespace(inputs=("side",))}
NAMES = tuple(FIGURES)
figure = FIGURES.get


def draw(name, parameters, results, said):
    content = parameters.settings.title.encode()
    if name == "two":
        if not parameters.settings.extra:
            return {}, "not drawn"
        content += results["side"].read_bytes()
    return {f"figures/{name}.svg": content + said.encode()}, f"this is {name}"

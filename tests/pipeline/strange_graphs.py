"""Strange dvc.yaml: edits of the toy study's own, as (what it is, text to replace, what stands there then)."""

from collections.abc import Iterator

_FALL = "  fall:\n    cmd: bipedstudy run fall"
_OUTS = "outs: [results/fall.h5]"
_DEPS = "deps: [stages/fall, stages/body]"
_PARAMS = "      - params/fall.yaml:\n"

_EDITS: tuple[tuple[str, str, str], ...] = (
    ("another key at the top", "stages:\n", "vars: [a.yaml]\nstages:\n"),
    ("no stages", "stages:\n", "stage:\n"),
    ("another command", "cmd: bipedstudy run fall", "cmd: rm -rf /"),
    ("two commands", "cmd: bipedstudy run fall", "cmd: [bipedstudy run fall, rm -rf /]"),
    ("command with more", "cmd: bipedstudy run fall", "cmd: bipedstudy run fall; rm -rf /"),
    ("no command", "    cmd: bipedstudy run fall\n", ""),
    ("unknown key", _FALL, _FALL + "\n    wdir: /"),
    ("misspelt key", "deps: [stages/fall, stages/body]", "dep: [stages/fall, stages/body]"),
    ("key twice", _FALL, _FALL + "\n    cmd: bipedstudy run fall"),
    ("stage twice", "  side:\n", "  fall:\n"),
    ("stage that is a list", _FALL, "  fall: []\n  other:\n    cmd: bipedstudy run other"),
    ("stage that is null", _FALL, "  other:\n  fall:\n    cmd: bipedstudy run fall"),
    ("out outside of the study", _OUTS, "outs: [results/fall.h5, /tmp/x]"),
    ("out with a step up", _OUTS, "outs: [results/fall.h5, results/../x]"),
    ("out outside of results", _OUTS, "outs: [results/fall.h5, params/fall.yaml]"),
    ("out that is the lock", _OUTS, "outs: [results/fall.h5, results/.cache/lock]"),
    ("out that is the report", _OUTS, "outs: [results/fall.h5, results/report.html]"),
    ("out that is the log", _OUTS, "outs: [results/fall.h5, results/log/fall.log]"),
    ("out of another stage", _OUTS, "outs: [results/fall.h5, results/side.bin]"),
    ("out inside of another's folder", _OUTS, "outs: [results/fall.h5, results/figures/one.svg]"),
    ("out twice", _OUTS, "outs: [results/fall.h5, results/fall.h5]"),
    ("out that is the whole folder", _OUTS, "outs: [results/fall.h5, results]"),
    ("out with a drive", _OUTS, "outs: [results/fall.h5, 'C:results/x']"),
    ("out with a backslash", _OUTS, "outs: [results/fall.h5, 'results\\x']"),
    ("out with a null byte", _OUTS, 'outs: [results/fall.h5, "results/x\\0"]'),
    ("out that is a mapping", _OUTS, "outs: [results/fall.h5, {results/x: {cache: false}}]"),
    ("outs that are a word", _OUTS, "outs: results/fall.h5"),
    ("outs that are a number", _OUTS, "outs: 3"),
    ("outs that are null", _OUTS, "outs:"),
    ("no artefact among the outs", _OUTS, "outs: [results/other.h5]"),
    ("input that no stage makes", _DEPS, "deps: [stages/fall, stages/body, results/nosuch.h5]"),
    ("input of its own", _DEPS, "deps: [stages/fall, stages/body, results/fall.h5]"),
    ("circle of stages", _DEPS, "deps: [stages/fall, stages/body, results/bounce.h5]"),
    ("input outside of the study", _DEPS, "deps: [stages/fall, stages/body, /etc/passwd]"),
    ("input that is a mapping", _DEPS, "deps: [stages/fall, {stages/body: 1}]"),
    ("parameters of another folder", _PARAMS, "      - ../fall.yaml:\n"),
    ("parameters that are a word", "    params:\n      - params/side.yaml:\n", "    params: side\n"),
    ("parameters that are a number", "    params:\n      - params/side.yaml:\n", "    params: 3\n"),
    ("parameter key that is none", "params/ground.yaml: [gravity]", "params/ground.yaml: [gravitty]"),
    ("parameter keys that are a mapping", "params/ground.yaml: [gravity]", "params/ground.yaml: {gravity: 1}"),
    ("parameter file that is not there", _PARAMS, "      - params/nosuch.yaml:\n"),
    ("tag", "cmd: bipedstudy run fall", "cmd: !!python/object/apply:os.system [true]"),
    ("anchor inside itself", _DEPS, "deps: &a [*a]"),
    ("variable", "cmd: bipedstudy run fall", "cmd: bipedstudy run ${stage}"),
    ("foreach", _FALL, "  many:\n    foreach: [1, 2]\n    do: {cmd: bipedstudy run many}\n" + _FALL),
)
#: Names of a stage as they stand in YAML, each with command and outs that fit it.
_NAMES = {
    "number": "1", "null": "~", "step up": "../fall", "blank": "fall down", "line end": "fa\\nll",
    "null byte": "fa\\0ll",
    "keyword": "import", "no code": "nosuch", "hidden": ".fall", "package": "fall.run", "dunder": "__init__",
    "not in ASCII": "fäll", "surrogate": "\\ud800", "very long": "f" * 300, "empty": "", "option": "--help",
}  # fmt: skip


def graphs(text: str) -> Iterator[tuple[str, str]]:
    """Each strange graph that the right one can be edited to."""
    for name, old, new in _EDITS:
        assert text.count(old) >= 1, f"{name}: {old}"
        yield name, text.replace(old, new, 1)
    for name, written in _NAMES.items():
        named = text.replace(_FALL, f'  "{written}":\n    cmd: "bipedstudy run {written}"')
        yield f"stage called by a {name}", named.replace("results/fall.h5", f'"results/{written}.h5"')

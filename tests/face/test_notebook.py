"""The notebook that asks every question runs from top to bottom, and leaves no declared question out."""

import ast
import json

import pytest

from bipedstudy import questions


def test_the_notebook_asks_every_question(notebook):
    called = {node.func.attr for cell in notebook for node in ast.walk(ast.parse(cell))
              if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
              and getattr(node.func.value, "id", "") == "bs"}  # fmt: skip
    assert [name for name in questions.names() if name not in called] == []


@pytest.mark.slow
def test_the_notebook_runs_from_top_to_bottom(notebook, tmp_path, monkeypatch, capsys):
    """A cell shows its last expression, as Jupyter does."""
    monkeypatch.chdir(tmp_path)
    known: dict[str, object] = {}
    shown = []
    for number, cell in enumerate(notebook):
        tree = ast.parse(cell, f"cell {number}")
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, f"cell {number}", "exec"), known)
        if isinstance(last, ast.Expr):
            shown.append(repr(eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), known)))
    shown = [text for text in shown if text != "None"]  # of the cells that run a command of the shell
    assert len(shown) == len(questions.names()) and all(len(text) > 10 for text in shown), shown
    assert "0.64034 ->" in shown[7] and "of the twin's (2 % requested)" in shown[8], shown[7:9]
    assert "synthetic" in shown[9] and (tmp_path / "lab/twin.urdf").read_text().startswith("<?xml")


@pytest.fixture(scope="module")
def notebook(repository):
    """The code of each cell, without outputs: they are made where it is run."""
    found = json.loads((repository / "docs/questions.ipynb").read_text(encoding="utf-8"))
    cells = [cell for cell in found["cells"] if cell["cell_type"] == "code"]
    assert found["nbformat"] == 4 and not any(cell["outputs"] for cell in cells)
    return ["".join(cell["source"]) for cell in cells]

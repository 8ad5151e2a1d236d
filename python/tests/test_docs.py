"""What the documents show runs: the notebooks, the Python of README.md and docs/use_it.md."""
import os
import pathlib
import re

import nbclient
import nbformat
import pytest
from conftest import SOURCE

NOTEBOOKS = sorted((SOURCE / "docs" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(notebook, tmp_path):
    content = nbformat.read(notebook, as_version=4)
    nbformat.validate(content)
    assert all(not cell.get("outputs") for cell in content.cells), "outputs are not kept"
    nbclient.NotebookClient(content, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert any("image/png" in output.get("data", {}) for cell in content.cells for output in cell.get("outputs", []))


def blocks_of(page):
    return re.findall(r"^```python\n(.*?)^```", (SOURCE / page).read_text(), re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", ["README.md", "docs/use_it.md"])
def test_page(page, tmp_path, monkeypatch):
    """The blocks of a page in turn, as one program."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    # exports in other programs: tests/deploy/tools_test.py
    blocks = [block for block in blocks_of(page) if "# export:" not in block]
    assert blocks
    exec(compile("\n".join(blocks), page, "exec"), {"__name__": "__main__"})
    assert any(tmp_path.iterdir())


def test_readme_is_ten_lines():
    assert len([line for line in blocks_of("README.md")[0].splitlines() if line.strip()]) <= 10

"""Runs the notebook, and holds its figures and numbers to bounds."""

import json
from pathlib import Path

import nbformat
from nbclient import NotebookClient

NOTEBOOK = Path(__file__).resolve().parents[1] / "notebooks/published-figures.ipynb"
LAST_CELL = """
import json
print(json.dumps({"numbers": numbers.to_dict(), "z_p": [z_p.real, z_p.imag], "people": everybody.participant.nunique(),
                  "instances": len(changes.loc["trial"]), "truth_um": float(truth_um)}))
"""


def test_the_notebook_draws_its_figures_and_finds_its_numbers(tmp_path: Path) -> None:
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        assert not cell.get("outputs"), f"{cell.id}: outputs are not kept in the repository"
    notebook.cells.append(nbformat.v4.new_code_cell(LAST_CELL))
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}}).execute()

    drawn = {
        cell.id: list(output.data)
        for cell in notebook.cells
        for output in cell.get("outputs", [])
        if output.output_type == "display_data" or output.output_type == "execute_result"
    }
    for figure in ["raw-figure", "impedance-figure", "fig11", "fig13", "fig14", "fig15"]:
        assert "image/png" in drawn[figure], drawn
    assert "image/svg+xml" in drawn["svg"], drawn

    found = json.loads(notebook.cells[-1].outputs[-1].text)
    numbers = found["numbers"]
    assert found["people"] == 5
    assert found["instances"] >= 35
    assert 5.0 < found["z_p"][0] < 9.0
    assert abs(found["z_p"][1]) < 1.0
    for method, least in {"paper": 0.4, "dynamic": 0.99, "trial": 0.995}.items():
        assert least < numbers[method]["R² of μ"] <= 1.0, numbers
        assert numbers[method]["ρ(μ estimated, μ)"] > 0.9, numbers
    assert numbers["paper"]["R² of μ"] < 0.95, numbers
    # The total interval includes assumed constants of the calibration; the published bias of σ_t is larger.
    assert abs(numbers["trial"]["σ_t (µm)"] / found["truth_um"] - 1) < 0.35, numbers
    assert numbers["paper"]["σ_t (µm)"] > 1.2 * found["truth_um"], numbers

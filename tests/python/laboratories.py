"""Answers of the SQL and the Python in the handbook's chapter on studies of many laboratories, next to those of pandas.

Arguments: the chapter; `instances.parquet` of `analyze --tables`; participants of each laboratory, as `oslo=sub-01,sub-03`. The parts are in the
current folder.
"""

import contextlib
import io
import json
import re
import sys
from pathlib import Path

import duckdb
import pandas as pd

chapter, table, *laboratories = sys.argv[1:]
text = Path(chapter).read_text(encoding="utf-8")
blocks = re.findall(r"^```(sql|python)\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
connection = duckdb.connect()
answers, printed = [], io.StringIO()
for language, block in blocks:
    if language == "python":
        with contextlib.redirect_stdout(printed):
            exec(block, {})
    elif block.startswith(("SELECT", "WITH")):
        answers.append(json.loads(connection.sql(block).df().to_json(orient="records", double_precision=15)))
    else:
        connection.execute(block)

instances = pd.read_parquet(table)
expected = []
for lab, participants in sorted(laboratory.split("=") for laboratory in laboratories):
    here = instances[instances.participant.isin(participants.split(","))]
    falls = here.groupby("participant").fall_of_mu.mean()
    known = here.dropna(subset=["gap_at_crest_m"])
    centred = known[["normal_n", "gap_at_crest_m"]] - known.groupby("participant")[["normal_n", "gap_at_crest_m"]].transform("mean")
    slope = (centred.normal_n * centred.gap_at_crest_m).sum() / (centred.normal_n**2).sum()
    expected.append([
        {"lab": lab, "people": here.participant.nunique(), "recordings": here.recording.nunique(), "instances": len(here),
         "calibrated": int(here.calibrated.sum()), "simulated": int(here.simulated.sum())},
        {"lab": lab, "people": len(falls), "fall": falls.mean(), "standard_error": None if len(falls) == 1 else falls.sem()},
        {"lab": lab, "um_per_n": 1e6 * slope, "instances": len(known)},
    ])
print(json.dumps({"answers": answers, "expected": [list(rows) for rows in zip(*expected)], "printed": printed.getvalue()}))

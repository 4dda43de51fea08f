"""CSV files say what the rows say."""

import csv
import io

from benchmarks.csv_export import to_csv
from tests.bench.making import make_row


def test_every_field_of_every_row_comes_back() -> None:
    rows = [
        make_row(agent='a,"b"\n<script>', index=3, complete=0.1, buffer_overflows=None),
        make_row(status="error", message="boom; ünïcode", success=False),
    ]
    read = list(csv.DictReader(io.StringIO(to_csv(rows))))
    assert len(read) == 2
    for record, row in zip(read, rows, strict=True):
        expected = {k: "" if v is None else str(v) for k, v in vars(row).items()}
        assert record == expected


def test_no_rows_are_a_header() -> None:
    assert to_csv([]).startswith("schema,agent,env,condition,index,repeat,seed,status,success")
    assert to_csv([]).count("\n") == 1

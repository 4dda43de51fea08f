"""Rows for spreadsheets and data frames."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import fields

from benchmarks.rows import Row


def to_csv(rows: Iterable[Row]) -> str:
    """A header and one line per row, with the fields of ``Row``; None is an empty cell."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [field.name for field in fields(Row)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(map(vars, rows))
    return text.getvalue()

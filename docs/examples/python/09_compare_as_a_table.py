"""Compares two surfaces that age, and writes every figure as a row of a table.

    09_compare_as_a_table.py HISTORY TRANSFER TABLE.csv
"""
import csv
import sys

import patinate

_, left, right, table = sys.argv
report = patinate.compare(left, right, num_resamples=20)
rows = report.rows()                                              # or report.to_dataframe().to_csv(table)
with open(table, "w", newline="") as file:
    writer = csv.DictWriter(file, rows[0])
    writer.writeheader()
    writer.writerows(rows)
print(f"{len(rows)} figures; colors differ by {report.colors.figures.color_distribution.value:.2f} {report.colors.figures.color_distribution.unit}")

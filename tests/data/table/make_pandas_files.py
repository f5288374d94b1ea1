"""Writes pandas_*.h5 and pytables.h5; the committed files come from pandas 1.5.3 and PyTables 3.7.0 (Debian 12)."""

import numpy as np
import pandas as pd
import tables

frame = pd.DataFrame(
    {
        "mu_s_pp": [0.1, 1.0 / 3.0, 0.9],
        "angle_deg": [20.5, np.nan, 31.25],
        "run": np.array([1, 2, 2**40], dtype="int64"),
        "lab": ["Delft", "Freiberg", "Tōkyō"],
        "passed": [True, False, True],
    }
)
options = {"mode": "w", "format": "table", "complib": "zlib", "complevel": 5}
frame.to_hdf("pandas_table.h5", key="runs", **options)
frame.to_hdf("pandas_data_columns.h5", key="runs", data_columns=True, index=False, **options)
frame.drop(columns="lab").to_hdf("pandas_fixed.h5", key="runs", mode="w", format="fixed")


class Row(tables.IsDescription):
    run = tables.Int32Col(pos=0)
    mass_kg = tables.Float32Col(pos=1)
    material = tables.StringCol(8, pos=2)
    is_valid = tables.BoolCol(pos=3)
    position_m = tables.Float64Col(shape=(3,), pos=4)


with tables.open_file("pytables.h5", "w") as file:
    table = file.create_table("/study", "runs", Row, createparents=True)
    for i in range(4):
        table.append([(i + 1, 0.5 * i, f"pellet_{i}".encode(), i % 2 == 0, (i, 10.0 * i, -i))])
    table.cols.run.create_index()

"""Writes arrays.h5 (as h5py users store arrays) and matlab_v73.mat (the layout that MATLAB's save -v7.3 writes)."""

import h5py
import numpy as np

with h5py.File("arrays.h5", "w") as file:
    values = np.arange(12.0).reshape(4, 3)
    file["plain"] = values
    for attribute in ("column_names", "columns", "names"):
        file[f"by_{attribute}"] = values.astype("f4")
        file[f"by_{attribute}"].attrs[attribute] = ["mu_s", "mu_r", "angle_deg"]
    file["by_names"].attrs["names"] = np.array([b"mu_s", b"mu_r", b"angle_deg"])
    file["misnamed"] = values
    file["misnamed"].attrs["columns"] = ["mu_s", "mu_r"]
    file.create_dataset("chunked", data=np.arange(60000).reshape(20000, 3) % 97, chunks=(1000, 2), compression="gzip")
    file["records"] = np.array(
        [(1, 0.5, b"ab", True, (1, 2)), (2, 1.5, b"abc", False, (3, 4))],
        dtype=[("run", "u2"), ("mass_kg", ">f4"), ("note", "S3"), ("good", "?"), ("site", "i4", (2,))],
    )
    file["texts"] = np.array([("a", 1), ("ß", 2)], dtype=[("lab", h5py.string_dtype()), ("run", "i8")])
    file["nested"] = np.zeros(2, dtype=[("a", [("b", "f8")])])
    file["cube"] = np.zeros((2, 3, 4))
    file["mixed/x"] = np.arange(4.0)
    file["mixed/position_m"] = values
    file["words/matrix"] = np.array([[b"a", b"b"], [b"c", b"d"]])


def matlab(parent, name, value, kind="double", **attributes):
    """MATLAB stores an m x n array with the extents (n, m)."""
    dataset = parent.create_dataset(name, data=np.asarray(value).T)
    dataset.attrs["MATLAB_class"] = np.bytes_(kind)
    for key, attribute in attributes.items():
        dataset.attrs[key] = attribute


with h5py.File("matlab_v73.mat", "w", userblock_size=512) as file:
    array = np.array([[1.0, 10.0, 100.0], [2.0, 20.0, 200.0]])
    matlab(file, "A", array)
    runs = file.create_group("runs")
    runs.attrs["MATLAB_class"] = np.bytes_("struct")
    matlab(runs, "mu_s", np.array([[0.1], [0.2], [0.3]]))
    matlab(runs, "angle_deg", np.array([[21.0, 22.0, np.nan]]), kind="double")
    matlab(runs, "passed", np.array([[1], [0], [1]], dtype="u1"), kind="logical", MATLAB_int_decode=np.int32(1))
    matlab(runs, "position", np.array([[1, 2], [3, 4], [5, 6]], dtype="i4"), kind="int32")
    matlab(runs, "temperature", np.array([[293.0]]))
    matlab(file, "t", np.array([[0xDD000000, 2, 1, 1, 1, 1]], dtype="u4"), kind="table", MATLAB_object_decode=np.int32(3))
    matlab(file, "label", np.array([[ord(c) for c in "pellet"]], dtype="u2"), kind="char", MATLAB_int_decode=np.int32(2))
    matlab(file, "none", np.array([[0, 0]], dtype="u8"), MATLAB_empty=np.uint8(1))
    complex_type = np.dtype([("real", "f8"), ("imag", "f8")])
    matlab(file, "z", np.zeros((2, 3), dtype=complex_type))
    sparse = file.create_group("sparse")
    sparse.attrs["MATLAB_class"] = np.bytes_("double")
    sparse.attrs["MATLAB_sparse"] = np.uint64(3)
    sparse["data"], sparse["ir"], sparse["jc"] = np.ones(2), np.arange(2, dtype="u8"), np.arange(3, dtype="u8")
    matlab(file, "#refs#/a", np.array([[1.0, 2.0, 3.0]]))
    matlab(file, "#subsystem#/MCOS", np.array([[1.0, 2.0, 3.0]]))
    cells = file.create_group("cells")
    cells.attrs["MATLAB_class"] = np.bytes_("struct")
    matlab(cells, "name", np.array([[file["#refs#/a"].ref] * 3], dtype=h5py.ref_dtype), kind="cell")
    many = file.create_group("array_of_structs")
    many.attrs["MATLAB_class"] = np.bytes_("struct")
    many.create_dataset("x", data=np.array([[file["#refs#/a"].ref] * 3], dtype=h5py.ref_dtype))
with open("matlab_v73.mat", "r+b") as file:
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  6 12:00:00 2025 HDF5 schema 1.00 ."
    file.write(text.ljust(124) + b"\x00\x02IM")

# Small files of every layout that the HDF5 reader knows, seeds of its fuzzer: python3 make_hdf5_seeds.py FOLDER
import sys, h5py, numpy as np
def new(name, **how):
    return h5py.File(f"{sys.argv[1]}/{name}.h5", "w", **how)
for version in ("earliest", "latest"):
    with new(f"columns_{version}", libver=version) as f:
        g = f.create_group("t", track_order=version == "latest")
        g["x"] = np.array([0.5, 1.5]); g["n"] = np.array([1, 2], dtype=">i2"); g["s"] = ["a", "b"]
        g["x"].attrs.update({"unit": "m", "role": "factor", "lower": 0.0, "upper": 2.0, "scale": "linear"})
        g.attrs["column_order"] = ["s", "x", "n"]; g.attrs["repose_format"] = "table 1"
    with new(f"chunked_{version}", libver=version) as f:
        f.create_dataset("t/z", data=np.arange(20.0), chunks=(7,), compression="gzip", shuffle=True, fletcher32=True)
        f.create_dataset("t/u", shape=(20,), maxshape=(None,), chunks=(8,), dtype="u8")
with new("matrix") as f:
    f["a"] = np.arange(6.0).reshape(3, 2); f["a"].attrs["column_names"] = ["p", "q"]
with new("records") as f:
    f["r"] = np.array([(1.0, 2, b"ab", [1, 2])], dtype=[("x", "f4"), ("n", "u1"), ("s", "S3"), ("v", "i4", (2,))])
with new("fixed_texts") as f:
    f["t/a"] = np.array([b"ab", b"c"]); f["t/flag"] = np.array([True, False])
with new("odd") as f:
    f["t/c"] = np.zeros(2, dtype=complex); f["t/e"] = h5py.Empty("f8"); f["t/l"] = h5py.SoftLink("/t"); f["t/x"] = 3.0
    f["t/ref"] = np.array([f["t"].ref], dtype=h5py.ref_dtype)
with new("matlab", userblock_size=512) as f:
    f["A"] = np.arange(6.0).reshape(2, 3); f["A"].attrs["MATLAB_class"] = np.bytes_("double")
    s = f.create_group("s"); s.attrs["MATLAB_class"] = np.bytes_("struct")
    s["x"] = np.arange(3.0).reshape(1, 3); s["x"].attrs["MATLAB_class"] = np.bytes_("double")

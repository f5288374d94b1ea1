// The first bytes of an HDF5 file, looked at before the library opens it.
#pragma once

#include <filesystem>

namespace repose::table::hdf5 {

/// Throws StorageError if an HDF5 file has a driver information block: its size is believed by HDF5
/// 1.10 before anything is checked, so that a damaged one asks for 4 GB. Only files split over
/// several (drivers "family" and "multi") have it, and no table is stored so. [HDF5FileFormat,
/// section II.A]
void refuse_driver_information(const std::filesystem::path& path);

}  // namespace repose::table::hdf5

// What must hold for any bytes that a reader is given; the fuzzers and the replay of their corpus
// call it.
#pragma once

#include <string_view>

namespace repose::fuzz {

/// Bytes as CSV are a table or an InputError, and a table written as CSV is the same table when it
/// is read. Ends the process if not. Returns the number of tables.
int check_csv(std::string_view bytes);

/// Bytes as an HDF5 file are tables, each of which can be read at once and in blocks with the same
/// result, or an Error. Ends the process if not.
int check_hdf5(std::string_view bytes);

}  // namespace repose::fuzz

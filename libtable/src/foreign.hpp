// What other programs leave in their files beside the values: names, classes, notes to themselves.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hdf5.hpp"

namespace repose::table {

/// Attribute `name` if it is a text.
std::optional<std::string> text_if_any(const hdf5::Object& object, const char* name);

/// "double", "struct", "cell", ...; nothing if MATLAB did not write the object.
std::optional<std::string> matlab_class(const hdf5::Object& object);
/// Whether MATLAB stored an array of numbers with at least one element.
bool holds_matlab_numbers(const hdf5::Object& dataset);
/// Throws InputError with the way out unless the dataset holds an array of numbers or is
/// none of MATLAB's.
void refuse_matlab_objects(const hdf5::Object& dataset);
/// Why a group of datasets is no table, and the way out: a sparse MATLAB array, a pandas frame with
/// format="fixed". Nothing if it may be one.
std::optional<std::string> why_unreadable(const hdf5::Object& group);

/// Names of the columns that pandas put into the array `member`; none if it did not say.
std::vector<std::string> pandas_names(const hdf5::Object& dataset, const std::string& member);
/// Whether `member` is the index of a data frame.
bool is_pandas_index(const hdf5::Object& dataset, const std::string& member);

/// Whether a path leads into what PyTables and MATLAB keep for themselves.
bool is_internal_path(std::string_view path);
/// Whether an attribute says how a program stored the table, not what the table is.
bool is_internal_attribute(std::string_view name);

/// The texts of a list in Python's pickle protocol 0, as pandas writes it; nothing for any other
/// object. (Python's pickletools document the opcodes.)
std::optional<std::vector<std::string>> unpickled_texts(std::string_view pickle);

}  // namespace repose::table

// The wall around the HDF5 C library: nothing outside hdf5*.cpp calls it, and every call is
// checked.
//
// An Object is an open file, group or dataset together with the text that names it in messages.
// Each function throws StorageError with that text and the library's own reason.
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "repose/table/table.hpp"

namespace repose::table::hdf5 {

/// Held as long as HDF5 is used: one thread at a time, and the library prints nothing meanwhile.
class Session {
 public:
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

 private:
  std::lock_guard<std::mutex> lock_;
  H5E_auto2_t print_ = nullptr;
  void* print_data_ = nullptr;
};

/// Owns one HDF5 identifier.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle(hid_t id, Close closer) : id_(id), closer_(closer) {}
  Handle(Handle&& other) noexcept;
  Handle& operator=(Handle&&) = delete;
  ~Handle();
  hid_t get() const { return id_; }
  /// Closes now and returns what the library said; a destructor would have to swallow it.
  herr_t close();

 private:
  hid_t id_;
  Close closer_;
};

struct Object {
  Handle handle;
  std::string where;  ///< "FILE:/table/angle"
  hid_t id() const { return handle.get(); }
};

/// Throws StorageError "`what`: the deepest reason on the library's error stack".
[[noreturn]] void fail(const std::string& what);

/// Returns `result` of a call, or fails if it is negative.
template <class T>
T checked(T result, const std::string& what) {
  if (result < 0) fail(what);
  return result;
}

// Files and groups (hdf5.cpp).
Object open_file(const std::filesystem::path& path);
/// Creates `path`; messages speak of `name`, the file that it will become.
Object create_file(const std::filesystem::path& path, const std::string& name);
/// Writes everything out and closes; a full disk shows here.
void finish_file(Object file);

Object open_group(const Object& file, const std::string& path);
/// Creates the group and its parents, keeping the order in which columns come; "/" is opened.
Object create_group(const Object& file, const std::string& path);

enum class ChildKind { dataset, group, other };
struct Child {
  std::string name;
  ChildKind kind;
};
/// What a group holds, in order of creation if the file knows it, else of names.
std::vector<Child> children(const Object& group);
/// Absolute paths of all groups of the file, "/" first.
std::vector<std::string> all_groups(const Object& file);

// Datasets (hdf5.cpp, hdf5_values.cpp).
enum class PathKind { absent, group, dataset, other };
/// What `path`, absolute or relative, leads to.
PathKind kind_of(const Object& parent, const std::string& path);
Object open_dataset(const Object& parent, const std::string& path);
/// Extents; none for a scalar, nothing for a dataset that is declared empty.
std::optional<std::vector<hsize_t>> extents(const Object& dataset);
bool holds_numbers(const Object& dataset);

/// A member of a compound type; more than one element: an array.
struct Member {
  std::string name;
  std::size_t elements;
};
/// None if the type is not compound.
std::vector<Member> members(const Object& dataset);

/// Where a column lies within a dataset: all of a 1-D one, a column of a 2-D one, an element of a
/// member of a compound one.
struct Part {
  int row_axis = 0;    ///< of a 2-D dataset: the axis along which rows are counted
  hsize_t column = 0;  ///< of a 2-D dataset: place on the other axis
  std::string member = {};
  std::size_t element = 0;
};
struct RowRange {
  hsize_t first;
  hsize_t count;
};
/// Rows that exist of a 1-D or 2-D dataset: integers, decimal numbers or text. Throws InputError
/// for any other type.
Values read_values(const Object& dataset, const Part& part, const RowRange& rows);
/// Rows that HDF5 reads at once; 1 if it reads any number equally well.
hsize_t chunk_rows(const Object& dataset, const Part& part);
Object write_values(const Object& group, const std::string& name, const Values& values);

/// A dataset of no rows that grows by append_values(), `chunk_rows` at a time; compressed if that
/// gains anything on `sample`, values of its type.
Object create_growing(const Object& group, const std::string& name, const Values& sample,
                      hsize_t chunk_rows);
/// Adds values to a dataset that has `rows`.
void append_values(const Object& dataset, hsize_t rows, const Values& values);

// Attributes (hdf5_attributes.cpp).
std::optional<Attribute> read_attribute(const Object& object, const std::string& name);
/// All whose type is one of Attribute's.
Attributes read_attributes(const Object& object);
void write_attribute(const Object& object, const std::string& name, const Attribute& value);

}  // namespace repose::table::hdf5

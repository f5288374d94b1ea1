#include "hdf5.hpp"

#include <fmt/format.h>

#include <fstream>
#include <system_error>
#include <utility>

#include "repose/base/error.hpp"
#include "superblock.hpp"

namespace repose::table::hdf5 {
namespace {

std::mutex& process_mutex() {
  static std::mutex mutex;
  return mutex;
}

herr_t keep_deepest(unsigned depth, const H5E_error2_t* error, void* reason) {
  if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(reason) = error->desc;
  return 0;
}

herr_t collect_group(hid_t, const char* name, const H5O_info_t* info, void* paths) {
  if (info->type != H5O_TYPE_GROUP) return 0;
  const std::string_view relative = name;
  static_cast<std::vector<std::string>*>(paths)->push_back(
      relative == "." ? "/" : fmt::format("/{}", relative));
  return 0;
}

std::string child_where(const Object& parent, std::string_view name) {
  if (!name.empty() && name.front() == '/') {  // absolute: from the file on
    return fmt::format("{}:{}", parent.where, name);
  }
  return fmt::format("{}{}{}", parent.where, parent.where.ends_with('/') ? "" : "/", name);
}

/// A soft or external link may lead nowhere; a hard one that does is damage.
bool is_hard_link(const Object& group, const std::string& name) {
  H5L_info_t info{};
  return H5Lget_info(group.id(), name.c_str(), &info, H5P_DEFAULT) < 0 ||
         info.type == H5L_TYPE_HARD;
}

bool is_old_matlab_file(const std::filesystem::path& path) {
  constexpr std::string_view kStart = "MATLAB 5.0";
  std::string start(kStart.size(), ' ');
  std::ifstream(path, std::ios::binary)
      .read(start.data(), static_cast<std::streamsize>(start.size()));
  return start == kStart;
}

Handle file_access() {
  Handle access(checked(H5Pcreate(H5P_FILE_ACCESS), "cannot set up access to HDF5 files"),
                H5Pclose);
  // From 1.8 on an attribute may exceed 64 kB (the names of 10 000 columns); h5py, MATLAB and
  // h5dump read it.
  checked(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V110),
          "cannot choose the version of HDF5 files");
  // After an error inside a damaged file nothing of it may stay open.
  checked(H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG),
          "cannot set up access to HDF5 files");
  // Our files appear whole, so locks protect nothing, and some network file systems refuse them.
  checked(H5Pset_file_locking(access.get(), false, true), "cannot switch off HDF5's file locks");
  return access;
}

/// HDF5 1.10 crashes at the program's exit on a file that it failed to close, as on a full disk. We
/// close what we open; nothing is left for it to do then. No effect if the program uses HDF5 before
/// it uses us.
void leave_out_cleanup_at_exit() {
  static const herr_t once = H5dont_atexit();
  static_cast<void>(once);
}

}  // namespace

Session::Session() : lock_(process_mutex()) {
  leave_out_cleanup_at_exit();
  H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
Session::~Session() {
  H5Eset_auto2(H5E_DEFAULT, print_, print_data_);
}

Handle::Handle(Handle&& other) noexcept
    : id_(std::exchange(other.id_, H5I_INVALID_HID)), closer_(other.closer_) {}
Handle::~Handle() {
  close();
}
herr_t Handle::close() {
  return id_ < 0 ? 0 : closer_(std::exchange(id_, H5I_INVALID_HID));
}

void fail(const std::string& what) {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_deepest, &reason);
  throw StorageError(reason.empty() ? what : fmt::format("{} ({})", what, reason));
}

Object open_file(const std::filesystem::path& path) {
  const std::string name = path.string();
  std::error_code error;
  if (!std::filesystem::exists(path, error))
    throw StorageError(fmt::format("cannot read {}: there is no such file", name));
  if (std::filesystem::is_directory(path, error))
    throw StorageError(fmt::format("cannot read {}: it is a directory", name));
  const htri_t is_hdf5 = H5Fis_hdf5(name.c_str());
  if (is_hdf5 < 0) fail(fmt::format("cannot read {}", name));
  if (is_hdf5 == 0 && is_old_matlab_file(path))
    throw StorageError(fmt::format(
        "cannot read {}: it is a MATLAB file of a version before 7.3; in MATLAB load it and save "
        "it with save(FILE, '-v7.3')",
        name));
  if (is_hdf5 == 0)
    throw StorageError(fmt::format(
        "cannot read {}: it is not an HDF5 file (or was cut off); a table is *.h5 or *.csv", name));
  refuse_driver_information(path);
  const Handle access = file_access();
  const hid_t id = H5Fopen(name.c_str(), H5F_ACC_RDONLY, access.get());
  return {
      Handle(checked(id, fmt::format("cannot read {}: it is damaged or cut off", name)), H5Fclose),
      name};
}

Object create_file(const std::filesystem::path& path, const std::string& name) {
  const Handle access = file_access();
  const hid_t id = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get());
  return {Handle(checked(id, fmt::format("cannot write {}", name)), H5Fclose), name};
}

void finish_file(Object file) {
  checked(H5Fflush(file.id(), H5F_SCOPE_GLOBAL), fmt::format("cannot write {}", file.where));
  checked(file.handle.close(), fmt::format("cannot write {}", file.where));
}

Object open_group(const Object& file, const std::string& path) {
  const std::string where = child_where(file, path);
  const Handle object(H5Oopen(file.id(), path.c_str(), H5P_DEFAULT), H5Oclose);
  if (object.get() < 0)
    throw StorageError(fmt::format("cannot read {}: there is no such group in the file", where));
  if (H5Iget_type(object.get()) != H5I_GROUP)
    throw StorageError(fmt::format("cannot read {}: it is not a group; a table is one", where));
  const hid_t id = H5Gopen2(file.id(), path.c_str(), H5P_DEFAULT);
  return {Handle(checked(id, fmt::format("cannot read {}", where)), H5Gclose), where};
}

Object create_group(const Object& file, const std::string& path) {
  if (path == "/") return open_group(file, path);
  const std::string where = child_where(file, path);
  const std::string what = fmt::format("cannot write {}", where);
  const Handle links(checked(H5Pcreate(H5P_LINK_CREATE), what), H5Pclose);
  checked(H5Pset_create_intermediate_group(links.get(), 1), what);
  const Handle creation(checked(H5Pcreate(H5P_GROUP_CREATE), what), H5Pclose);
  checked(H5Pset_link_creation_order(creation.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED),
          what);
  const htri_t exists = H5Lexists(file.id(), path.c_str(), H5P_DEFAULT);
  const hid_t id =
      exists > 0 ? H5Gopen2(file.id(), path.c_str(), H5P_DEFAULT)
                 : H5Gcreate2(file.id(), path.c_str(), links.get(), creation.get(), H5P_DEFAULT);
  return {Handle(checked(id, what), H5Gclose), where};
}

PathKind kind_of(const Object& parent, const std::string& path) {
  const Handle object(H5Oopen(parent.id(), path.c_str(), H5P_DEFAULT), H5Oclose);
  if (object.get() < 0) return PathKind::absent;
  const H5I_type_t type = H5Iget_type(object.get());
  return type == H5I_GROUP     ? PathKind::group
         : type == H5I_DATASET ? PathKind::dataset
                               : PathKind::other;
}

Object open_dataset(const Object& parent, const std::string& path) {
  const std::string where = child_where(parent, path);
  if (kind_of(parent, path) == PathKind::absent)
    throw StorageError(fmt::format(
        "cannot read {}: there is no such dataset in the file, or it is damaged", where));
  const hid_t id = H5Dopen2(parent.id(), path.c_str(), H5P_DEFAULT);
  return {Handle(checked(id, fmt::format("cannot read {}: it is damaged or no dataset", where)),
                 H5Dclose),
          where};
}

std::optional<std::vector<hsize_t>> extents(const Object& dataset) {
  const std::string what = fmt::format("cannot read {}", dataset.where);
  const Handle space(checked(H5Dget_space(dataset.id()), what), H5Sclose);
  if (H5Sget_simple_extent_type(space.get()) == H5S_NULL) return std::nullopt;
  const int rank = checked(H5Sget_simple_extent_ndims(space.get()), what);
  std::vector<hsize_t> result(static_cast<std::size_t>(rank));
  checked(H5Sget_simple_extent_dims(space.get(), result.data(), nullptr), what);
  return result;
}

std::vector<Child> children(const Object& group) {
  const std::string what = fmt::format("cannot read {}", group.where);
  const Handle creation(checked(H5Gget_create_plist(group.id()), what), H5Pclose);
  unsigned order = 0;
  checked(H5Pget_link_creation_order(creation.get(), &order), what);
  const H5_index_t index =
      (order & H5P_CRT_ORDER_TRACKED) != 0 ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
  H5G_info_t info{};
  checked(H5Gget_info(group.id(), &info), what);
  std::vector<Child> result;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const ssize_t size = checked(
        H5Lget_name_by_idx(group.id(), ".", index, H5_ITER_INC, i, nullptr, 0, H5P_DEFAULT), what);
    std::string name(static_cast<std::size_t>(size), '\0');
    checked(H5Lget_name_by_idx(group.id(), ".", index, H5_ITER_INC, i, name.data(), name.size() + 1,
                               H5P_DEFAULT),
            what);
    const Handle object(H5Oopen(group.id(), name.c_str(), H5P_DEFAULT), H5Oclose);
    if (object.get() < 0 && is_hard_link(group, name))
      fail(fmt::format("cannot read {}: it is damaged", child_where(group, name)));
    const H5I_type_t type = object.get() < 0 ? H5I_BADID : H5Iget_type(object.get());
    result.push_back({std::move(name), type == H5I_DATASET ? ChildKind::dataset
                                       : type == H5I_GROUP ? ChildKind::group
                                                           : ChildKind::other});
  }
  return result;
}

std::vector<std::string> all_groups(const Object& file) {
  std::vector<std::string> paths;
  checked(H5Ovisit2(file.id(), H5_INDEX_NAME, H5_ITER_INC, collect_group, &paths, H5O_INFO_BASIC),
          fmt::format("cannot read {}", file.where));
  return paths;
}

}  // namespace repose::table::hdf5

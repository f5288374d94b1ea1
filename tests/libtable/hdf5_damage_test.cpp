// Damaged files give an error that names the file, and never a crash.
#include <gtest/gtest.h>

#include <fstream>

#include "folder.hpp"
#include "repose/base/file.hpp"
#include "repose/base/random.hpp"
#include "repose/table/io.hpp"

// HDF5 1.10 itself leaks a few blocks when it gives up opening a file whose root is damaged.
extern "C" const char* __lsan_default_suppressions();  // NOLINT: the sanitizer's name
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}

namespace repose::table {
namespace {

class DamagedFile : public FolderTest {
 protected:
  void write(const std::string& bytes) {
    std::ofstream(file("damaged.h5"), std::ios::binary) << bytes;
  }
  std::string table_bytes() {
    Table table = every_kind_of_value();
    stamp_provenance(table, "repose", 1, {"a", "b"});
    write_table({file("whole.h5"), ""}, table);
    return read_file(file("whole.h5"));
  }
};

TEST_F(DamagedFile, CutOffAnywhereIsAStorageError) {
  const std::string bytes = table_bytes();
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 40) {
    write(bytes.substr(0, size));
    const std::string message = message_of<StorageError>([&] {
      read_table({file("damaged.h5"), ""});
    });
    EXPECT_NE(message.find("damaged.h5"), std::string::npos);
    EXPECT_THROW(list_tables(file("damaged.h5")), StorageError);
    EXPECT_THROW(read_attributes({file("damaged.h5"), ""}), StorageError);
  }
  write(bytes.substr(0, bytes.size() - 1));
  EXPECT_THROW(read_table({file("damaged.h5"), ""}), StorageError);
}

TEST_F(DamagedFile, ThatIsNoHdf5IsAStorageError) {
  write("x,y\n1,2\n");
  EXPECT_NE(message_of<StorageError>([&] {
              read_table({file("damaged.h5"), ""});
            }).find("not an HDF5 file"),
            std::string::npos);
  EXPECT_NE(message_of<StorageError>([&] {
              read_table({file("absent.h5"), ""});
            }).find("no such file"),
            std::string::npos);
  std::filesystem::create_directory(file("folder.h5"));
  EXPECT_NE(message_of<StorageError>([&] {
              read_table({file("folder.h5"), ""});
            }).find("is a directory"),
            std::string::npos);
}

// Metadata carry checksums in the version that we write; the values do not.
TEST_F(DamagedFile, WithWrongMetadataBytesIsAStorageError) {
  const std::string bytes = table_bytes();
  const std::size_t header = bytes.find("OHDR");
  ASSERT_NE(header, std::string::npos);
  for (std::size_t at = header; at < header + 64; ++at) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x5a);
    write(damaged);
    EXPECT_THROW(read_table({file("damaged.h5"), ""}), Error) << "byte " << at;
  }
}

}  // namespace
}  // namespace repose::table

// Damaged files give an error that names the file, and never a crash.
#include <gtest/gtest.h>

#include <fstream>

#include "folder.hpp"
#include "python.hpp"
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

TEST_F(DamagedFile, CutOffAtEvery64thByteIsAStorageError) {
  const std::string bytes = table_bytes();
  ASSERT_GT(bytes.size(), 64U * 64U);
  for (std::size_t size = 0; size < bytes.size(); size += 64) {
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

TEST_F(DamagedFile, OfAnotherProgramCutOffAtEvery64thByteIsAnError) {
  for (const char* name : {"arrays.h5", "pandas_table.h5", "matlab_v73.mat"}) {
    const std::string bytes = read_file(std::filesystem::path(REPOSE_TEST_DATA) / "table" / name);
    for (std::size_t size = 0; size < bytes.size(); size += 64) {
      write(bytes.substr(0, size));
      EXPECT_THROW(list_tables(file("damaged.h5")), StorageError) << name << ", " << size;
      EXPECT_THROW(read_table({file("damaged.h5"), ""}), StorageError) << name << ", " << size;
    }
  }
}

TEST_F(DamagedFile, ThatClaimsMoreValuesThanItCanHoldIsAStorageError) {
  run_python(file(""), R"(
with h5py.File(path, 'w') as f:
    f.create_dataset('huge/x', shape=(10**12,), chunks=(2**16,), dtype='f8')
    f.create_dataset('text/x', shape=(10**10,), chunks=(2**10,), dtype='S64')
    f.create_dataset('small/x', shape=(1000,), chunks=(100,), dtype='f8')
)");
  for (const char* group : {"/huge", "/text"})
    EXPECT_NE(message_of<StorageError>([&] {
                read_table({file("t.h5"), group});
              }).find("only 0 bytes are stored"),
              std::string::npos);
  EXPECT_EQ(read_table({file("t.h5"), "/small"}).numbers("x"), std::vector<double>(1000));
}

TEST_F(DamagedFile, OfMoreThanTenThousandColumnsIsRefused) {
  run_python(file(""), R"(
with h5py.File(path, 'w') as f:
    f.create_dataset('wide', data=np.zeros((2, 10000)))
    f.create_dataset('wider', data=np.zeros((2, 10001)))
    f.create_dataset('endless', shape=(1, 2**40), chunks=(1, 2**10), dtype='f8')
)");
  EXPECT_EQ(read_table({file("t.h5"), "/wide"}).columns().size(), 10000U);
  for (const char* group : {"/wider", "/endless"})
    EXPECT_NE(message_of<InputError>([&] {
                read_table({file("t.h5"), group});
              }).find("more than 10000 columns"),
              std::string::npos);
}

TEST_F(DamagedFile, ThatIsCsvCutOffAtEveryByteIsATableOrAnInputError) {
  const std::string text = csv_text(every_kind_of_value());
  for (std::size_t size = 0; size < text.size(); ++size) {
    try {
      EXPECT_LE(parse_csv(text.substr(0, size), "cut.csv").rows(), 7U);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("cut.csv"), std::string::npos);
    }
  }
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

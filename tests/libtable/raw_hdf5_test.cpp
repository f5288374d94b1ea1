// HDF5's own C functions read our tables as they are, and we read what they write: no wrapper of
// ours and no h5py between.
#include <gtest/gtest.h>
#include <hdf5.h>

#include "folder.hpp"
#include "repose/table/io.hpp"
#include "repose/table/writer.hpp"

namespace repose::table {
namespace {

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

/// An identifier that HDF5 gave, closed at the end of the scope; a failed call fails the test.
class Id {
 public:
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) { EXPECT_GE(id, 0); }
  ~Id() { close_(id_); }
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  operator hid_t() const { return id_; }  // NOLINT: stands for the identifier in C calls

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

hsize_t length_of(hid_t dataset) {
  const Id space(H5Dget_space(dataset), H5Sclose);
  EXPECT_EQ(H5Sget_simple_extent_ndims(space), 1);
  hsize_t length = 0;
  H5Sget_simple_extent_dims(space, &length, nullptr);
  return length;
}

template <class T>
std::vector<T> values_of(hid_t group, const char* name, hid_t type) {
  const Id dataset(H5Dopen2(group, name, H5P_DEFAULT), H5Dclose);
  std::vector<T> values(length_of(dataset));
  EXPECT_GE(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
  return values;
}

/// A scalar attribute of variable-length UTF-8 text.
std::string text_attribute(hid_t object, const char* name) {
  const Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  const Id type(H5Aget_type(attribute), H5Tclose);
  EXPECT_GT(H5Tis_variable_str(type), 0) << name;
  EXPECT_EQ(H5Tget_cset(type), H5T_CSET_UTF8) << name;
  char* text = nullptr;
  EXPECT_GE(H5Aread(attribute, type, &text), 0) << name;
  std::string copy = text == nullptr ? "" : text;
  H5free_memory(text);
  return copy;
}

double number_attribute(hid_t object, const char* name) {
  const Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  double value = 0.0;
  EXPECT_GE(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value), 0) << name;
  return value;
}

Texts texts_in(hid_t attribute_or_dataset, bool is_attribute) {
  const Id space(
      is_attribute ? H5Aget_space(attribute_or_dataset) : H5Dget_space(attribute_or_dataset),
      H5Sclose);
  const Id type(
      is_attribute ? H5Aget_type(attribute_or_dataset) : H5Dget_type(attribute_or_dataset),
      H5Tclose);
  std::vector<char*> pointers(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  if (is_attribute)
    H5Aread(attribute_or_dataset, type, pointers.data());
  else
    H5Dread(attribute_or_dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data());
  Texts texts(pointers.begin(), pointers.end());
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
  return texts;
}

class RawHdf5 : public FolderTest {};

/// What the C functions must find of every_kind_of_value() with seed 5 in "/table".
void expect_every_kind_of_value(const std::filesystem::path& path) {
  const Table table = every_kind_of_value();
  const Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  const Id group(H5Gopen2(file, "/table", H5P_DEFAULT), H5Gclose);
  H5G_info_t info{};
  ASSERT_GE(H5Gget_info(group, &info), 0);
  EXPECT_EQ(info.nlinks, 4U);
  const Id order(H5Aopen(group, "column_order", H5P_DEFAULT), H5Aclose);
  EXPECT_EQ(texts_in(order, true), table.names());
  EXPECT_EQ(text_attribute(group, "repose_format"), "table 1");
  EXPECT_EQ(number_attribute(group, "seed"), 5.0);

  EXPECT_TRUE(same_bits(values_of<double>(group, "mu_s_pp", H5T_NATIVE_DOUBLE),
                        table.column("mu_s_pp").values));
  EXPECT_EQ(Values(values_of<std::int64_t>(group, "run", H5T_NATIVE_INT64)),
            table.column("run").values);
  const Id notes(H5Dopen2(group, "note, \"quoted\"", H5P_DEFAULT), H5Dclose);
  EXPECT_EQ(Values(texts_in(notes, false)), table.column("note, \"quoted\"").values);

  const Id mu(H5Dopen2(group, "mu_s_pp", H5P_DEFAULT), H5Dclose);
  const Id type(H5Dget_type(mu), H5Tclose);
  EXPECT_GT(H5Tequal(type, H5T_IEEE_F64LE), 0);
  EXPECT_EQ(text_attribute(mu, "unit"), "1");
  EXPECT_EQ(text_attribute(mu, "role"), "factor");
  EXPECT_EQ(number_attribute(mu, "lower"), 1e-3);
  EXPECT_EQ(number_attribute(mu, "upper"), 1.0);
  EXPECT_EQ(text_attribute(mu, "scale"), "log");
  const Id flow(H5Dopen2(group, "mass_flow", H5P_DEFAULT), H5Dclose);
  EXPECT_EQ(text_attribute(flow, "unit"), "kg/s");
  EXPECT_EQ(text_attribute(flow, "role"), "response");
  EXPECT_EQ(H5Aexists(flow, "lower"), 0);
  const Id run(H5Dopen2(group, "run", H5P_DEFAULT), H5Dclose);
  EXPECT_EQ(text_attribute(run, "role"), "id");
}

Table with_seed() {
  Table table = every_kind_of_value();
  stamp_provenance(table, "repose design", 5, {});
  return table;
}

TEST_F(RawHdf5, ReadsATableWrittenAtOnce) {
  write_table({file("t.h5"), ""}, with_seed());
  expect_every_kind_of_value(file("t.h5"));
}

TEST_F(RawHdf5, ReadsATableWrittenInBlocks) {
  const Table table = with_seed();
  TableWriter writer({file("t.h5"), ""}, table.selected_rows({}));
  writer.append(table.selected_rows({0, 1, 2}));
  writer.append(table.selected_rows({3, 4, 5, 6}));
  writer.finish();
  expect_every_kind_of_value(file("t.h5"));
}

TEST_F(RawHdf5, ReadsATableOfSeveralPieces) {
  Doubles x;
  Texts text;
  for (int i = 0; i < 140000; ++i) {
    x.push_back(0.1 * i);
    text.push_back(std::to_string(i % 10));
  }
  Table table;
  table.add({.name = "x", .unit = "m", .values = x});
  table.add({.name = "text", .values = text});
  TableWriter writer({file("t.h5"), ""}, table.selected_rows({}));
  writer.append(table);
  writer.finish();
  const Id in(H5Fopen(file("t.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  const Id group(H5Gopen2(in, "/table", H5P_DEFAULT), H5Gclose);
  EXPECT_TRUE(same_bits(values_of<double>(group, "x", H5T_NATIVE_DOUBLE), x));
  const Id dataset(H5Dopen2(group, "text", H5P_DEFAULT), H5Dclose);
  EXPECT_EQ(texts_in(dataset, false), text);
  const Id column(H5Dopen2(group, "x", H5P_DEFAULT), H5Dclose);
  EXPECT_EQ(text_attribute(column, "unit"), "m");
}

void write_text(hid_t object, const char* name, const char* text) {
  const Id type(H5Tcopy(H5T_C_S1), H5Tclose);  // fixed length: what many C programs write
  H5Tset_size(type, std::string_view(text).size() + 1);
  const Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const Id attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  EXPECT_GE(H5Awrite(attribute, type, text), 0);
}

void write_number(hid_t object, const char* name, double value) {
  const Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const Id attribute(H5Acreate2(object, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT),
                     H5Aclose);
  EXPECT_GE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &value), 0);
}

/// A 1-D dataset of three rows; left open for attributes.
hid_t write_column(hid_t group, const char* name, hid_t file_type, hid_t memory_type,
                   const void* data) {
  const hsize_t rows = 3;
  const Id space(H5Screate_simple(1, &rows, nullptr), H5Sclose);
  const hid_t dataset =
      H5Dcreate2(group, name, file_type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  EXPECT_GE(H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), 0);
  return dataset;
}

TEST_F(RawHdf5, WritesAGroupThatIsATable) {
  {
    const Id out(H5Fcreate(file("c.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT),
                 H5Fclose);
    const Id group(H5Gcreate2(out, "runs", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    const Doubles friction{0.1, 0.2, 0.4};
    const Id mu(write_column(group, "mu_s_pp", H5T_IEEE_F64BE, H5T_NATIVE_DOUBLE, friction.data()),
                H5Dclose);
    write_text(mu, "unit", "1");
    write_text(mu, "role", "factor");
    write_text(mu, "scale", "log");
    write_number(mu, "lower", 0.05);
    write_number(mu, "upper", 0.8);
    const std::vector<float> angles{20.5F, 30.25F, 40.125F};
    const Id angle(
        write_column(group, "angle_deg", H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, angles.data()),
        H5Dclose);
    write_text(angle, "unit", "deg");
    write_text(angle, "role", "response");
    const std::vector<short> numbers{7, -8, 9};
    const Id run(write_column(group, "run", H5T_STD_I16BE, H5T_NATIVE_SHORT, numbers.data()),
                 H5Dclose);
    const Id fixed(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(fixed, 6);
    const Id lab(write_column(group, "lab", fixed, fixed, "Delft\0Leoben\xc3\xa9\0\0\0\0"),
                 H5Dclose);
  }
  const Table table = read_table({file("c.h5"), ""});
  EXPECT_EQ(table.names(), (Texts{"angle_deg", "lab", "mu_s_pp", "run"}));  // C keeps no order
  EXPECT_EQ(table.numbers("mu_s_pp"), (Doubles{0.1, 0.2, 0.4}));
  EXPECT_EQ(table.column("mu_s_pp").role, Role::factor);
  EXPECT_EQ(table.column("mu_s_pp").range, (FactorRange{0.05, 0.8, Scale::log}));
  EXPECT_EQ(table.numbers("angle_deg"), (Doubles{20.5, 30.25, 40.125}));
  EXPECT_EQ(table.column("angle_deg").unit, "deg");
  EXPECT_EQ(table.column("angle_deg").role, Role::response);
  EXPECT_EQ(table.integers("run"), (Integers{7, -8, 9}));
  EXPECT_EQ(table.texts("lab"), (Texts{"Delft", "Leoben", "é"}));
}

}  // namespace
}  // namespace repose::table

// h5py reads our tables as they are, and we read what it writes.
#include <gtest/gtest.h>

#include "folder.hpp"
#include "python.hpp"
#include "repose/table/io.hpp"

namespace repose::table {
namespace {

using Doubles = std::vector<double>;
using Integers = std::vector<std::int64_t>;
using Texts = std::vector<std::string>;

class H5py : public FolderTest {
 protected:
  void python(const std::string& script) { run_python(file(""), script); }
  Table read(const std::string& group) { return read_table({file("t.h5"), group}); }
  std::string refusal(const std::string& group) {
    return message_of<InputError>([&] { read(group); });
  }
};

TEST_F(H5py, ReadsOurTables) {
  Table table = every_kind_of_value();
  stamp_provenance(table, "repose design", 5, {"a.toml", "b.h5"});
  write_table({file("t.h5"), ""}, table);
  python(R"(
g = h5py.File(path, 'r')['table']
assert list(g.attrs['column_order']) == ['mu_s_pp', 'mass_flow', 'run', 'note, "quoted"']
assert list(g.keys()) == list(g.attrs['column_order']) or set(g.keys()) == set(g.attrs['column_order'])
assert g.attrs['repose_format'] == 'table 1' and g.attrs['command_line'] == 'repose design'
assert g.attrs['seed'] == 5 and list(g.attrs['parents']) == ['a.toml', 'b.h5']
mu = g['mu_s_pp']
assert mu.dtype == np.float64 and mu.shape == (7,)
assert mu[1] == 1.0 / 3.0 and np.signbit(mu[2]) and mu[3] == 5e-324
assert mu.attrs['unit'] == '1' and mu.attrs['role'] == 'factor'
assert mu.attrs['lower'] == 1e-3 and mu.attrs['upper'] == 1.0 and mu.attrs['scale'] == 'log'
assert g['mass_flow'].attrs['unit'] == 'kg/s' and 'lower' not in g['mass_flow'].attrs
assert g['run'].dtype == np.int64 and g['run'][3] == 2**63 - 1 and g['run'][4] == -2**63
notes = list(g['note, "quoted"'].asstr())
assert notes == ['', '1', 'nan', 'a,b', 'line\r\nbreak "x"', ' Schüttwinkel 안식각 ', 'plain'], notes
)");
}

TEST_F(H5py, WritesPlainGroupsThatAreTables) {
  python(R"(
with h5py.File(path, 'w') as f:
    g = f.create_group('plain')
    g['f32'] = np.array([0.5, 1.5], dtype='f4')
    g['u8'] = np.array([1, 255], dtype='u1')
    g['u64'] = np.array([1, 2**63 - 1], dtype='u8')
    g['be'] = np.array([-2, 3], dtype='>i2')
    g['flag'] = np.array([True, False])
    g['text'] = ['a', 'ß']
    g['bytes'] = np.array([b'ab', b'abc'])
    g['count'] = 5
    g.create_group('inner')['x'] = np.arange(3.0)
)");
  const Table table = read("/plain");
  EXPECT_EQ(table.names(), (Texts{"be", "bytes", "f32", "flag", "text", "u64", "u8"}));
  EXPECT_EQ(table.column("f32").values, Values(Doubles{0.5, 1.5}));
  EXPECT_EQ(table.column("u8").values, Values(Integers{1, 255}));
  EXPECT_EQ(table.integers("u64")[1], std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(table.integers("be"), (Integers{-2, 3}));
  EXPECT_EQ(table.integers("flag"), (Integers{1, 0}));
  EXPECT_EQ(table.texts("text"), (Texts{"a", "ß"}));
  EXPECT_EQ(table.texts("bytes"), (Texts{"ab", "abc"}));
  EXPECT_EQ(table.column("f32").unit, "1");
  EXPECT_EQ(table.column("f32").role, Role::none);
  EXPECT_EQ(list_tables(file("t.h5")), (Texts{"/plain", "/plain/inner"}));
}

TEST_F(H5py, OrderIsThatOfCreationOrAsSaid) {
  python(R"(
with h5py.File(path, 'w') as f:
    g = f.create_group('created', track_order=True)
    h = f.create_group('said')
    for name in ['c', 'a', 'b']:
        g[name] = np.arange(2)
        h[name] = np.arange(2)
    h.attrs['column_order'] = ['b', 'c']
    g['a'].attrs['role'] = 'response'
    g['a'].attrs['unit'] = 'deg'
)");
  EXPECT_EQ(read("/created").names(), (Texts{"c", "a", "b"}));
  EXPECT_EQ(read("/said").names(), (Texts{"b", "c"}));
  EXPECT_EQ(read("/created").names_with_role(Role::response), Texts{"a"});
  EXPECT_EQ(read("/created").column("a").unit, "deg");
}

TEST_F(H5py, WritesCompressedColumnsOfRowsByTheMillion) {
  python(R"(
with h5py.File(path, 'w') as f:
    f.create_dataset('t/x', data=np.arange(10**6) % 7, compression='gzip', shuffle=True, fletcher32=True)
)");
  const std::vector<std::int64_t> x = read("/t").integers("x");
  ASSERT_EQ(x.size(), 1000000u);
  for (std::size_t i = 0; i < x.size(); ++i) ASSERT_EQ(x[i], static_cast<std::int64_t>(i % 7));
}

TEST_F(H5py, WritesThingsThatAreRefusedByName) {
  python(R"(
with h5py.File(path, 'w') as f:
    f['long/a'], f['long/b'] = np.arange(3), np.arange(4)
    f['cube/a'] = np.zeros((3, 2, 2)); f['cube/b'] = np.zeros(3)
    f['complex/a'] = np.zeros(3, dtype=complex)
    f['infinite/a'] = np.array([0.0, -np.inf])
    f['wide/a'] = np.array([0, 2**63], dtype='u8')
    f['role/a'] = np.arange(3); f['role/a'].attrs['role'] = 'respons'
    f['scale/a'] = np.arange(3); f['scale/a'].attrs.update({'lower': 0.0, 'upper': 1.0, 'scale': 'ln'})
    f['twice/a'] = np.arange(3); f['twice'].attrs['column_order'] = ['a', 'a']
    f['gone/a'] = np.arange(3); f['gone'].attrs['column_order'] = ['a', 'b']
    f['empty/a'] = h5py.Empty('f8'); f['empty'].attrs['column_order'] = ['a']
    f['order/a'] = np.arange(3); f['order'].attrs['column_order'] = 'a'
    f['newer/a'] = np.arange(3); f['newer'].attrs['repose_format'] = 'table 2'
    f.create_group('bare')
    f['soft/a'] = h5py.SoftLink('/nowhere')
)");
  EXPECT_NE(refusal("/long").find("column \"b\" has 4 rows, but the table has 3"),
            std::string::npos);
  EXPECT_NE(refusal("/cube").find(":/cube/a has 3 dimensions"), std::string::npos);
  EXPECT_NE(refusal("/complex").find(":/complex/a has a type that is neither"), std::string::npos);
  EXPECT_NE(refusal("/infinite").find("row 2 of column \"a\" is infinite"), std::string::npos);
  EXPECT_NE(refusal("/wide").find("holds 9223372036854775808 in row 2"), std::string::npos);
  EXPECT_NE(refusal("/role").find("\"respons\" is not the role"), std::string::npos);
  EXPECT_NE(refusal("/scale").find("\"ln\"; allowed are linear and log"), std::string::npos);
  EXPECT_NE(refusal("/twice").find("a column \"a\" already"), std::string::npos);
  EXPECT_NE(refusal("/empty").find("has 0 dimensions"), std::string::npos);
  EXPECT_NE(refusal("/order").find("not an array of texts"), std::string::npos);
  EXPECT_NE(refusal("/newer").find("use a newer one"), std::string::npos);
  EXPECT_NE(refusal("/bare").find("holds no 1-D datasets"), std::string::npos);
  EXPECT_NE(refusal("/soft").find("holds no 1-D datasets"), std::string::npos);
  EXPECT_NE(message_of<StorageError>([&] { read("/gone"); }).find(":/gone/b"), std::string::npos);
}

TEST_F(H5py, AttributesOfOtherTypesAreIgnored) {
  python(R"(
with h5py.File(path, 'w') as f:
    f['t/a'] = np.arange(2)
    f['t'].attrs.update({'flag': True, 'pair': np.array([1, 2]), 'matrix': np.zeros((2, 2)),
                         'z': 1j, 'none': h5py.Empty('f8'), 'bytes': np.bytes_('abc'), 'f32': np.float32(0.5)})
)");
  EXPECT_EQ(read("/t").attributes, (Attributes{{"flag", std::int64_t{1}},
                                               {"pair", Doubles{1, 2}},
                                               {"bytes", std::string("abc")},
                                               {"f32", 0.5}}));
}

}  // namespace
}  // namespace repose::table

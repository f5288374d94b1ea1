#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>
#include <string>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/scene/case.hpp"
#include "repose/scene/case_keys.hpp"

namespace repose::scene {
namespace {

using Names = std::set<std::string>;

/// Every table of a case file in every variant that reads other keys. A mark <<TABLE>> is a place
/// for a line of that table, <<,TABLE>> one in an inline table.
constexpr const char* kEverything = R"(
<<>>
[run]
<<[run]>>
[domain]
lower_m = [-1, -1, -1]
upper_m = [1, 1, 1]
<<[domain]>>
[contact]
<<[contact]>>
[[material]]
name = "a"
density_kg_m3 = 1
poissons_ratio = 0.25
shear_modulus_pa = 1
<<[[material]]>>
[[pair]]
materials = ["a", "a"]
restitution = 0.5
mu_s = 0
mu_r = 0
<<[[pair]]>>
[[clump]]
name = "c"
spheres = [{position = [0, 0, 0], radius = 1 <<,[[clump]] spheres>>}]
<<[[clump]]>>
[[wall]]
name = "w1"
material = "a"
shape = "plane"
origin_m = [0, 0, 0]
normal = [0, 0, 1]
<<[[wall]]>>
[[wall]]
name = "w2"
material = "a"
shape = "rectangle"
origin_m = [0, 0, 0]
edge_u_m = [1, 0, 0]
edge_v_m = [0, 1, 0]
<<[[wall]]>>
[[wall]]
name = "w3"
material = "a"
shape = "disc"
centre_m = [0, 0, 0]
normal = [0, 0, 1]
radius_m = 1
<<[[wall]]>>
[[wall]]
name = "w4"
material = "a"
shape = "cylinder"
start_m = [0, 0, 0]
end_m = [0, 0, 1]
radius_m = 1
<<[[wall]]>>
[[wall]]
name = "w5"
material = "a"
shape = "cone"
start_m = [0, 0, 0]
end_m = [0, 0, 1]
start_radius_m = 1
end_radius_m = 0
<<[[wall]]>>
[[wall]]
name = "w6"
material = "a"
shape = "mesh"
file = "/w.stl"
<<[[wall]]>>
[[box]]
name = "b"
material = "a"
lower_m = [0, 0, 0]
upper_m = [1, 1, 1]
<<[[box]]>>
[[motion]]
walls = ["w3"]
type = "translate"
velocity_m_s = [0, 0, 0]
<<[[motion]]>>
[[motion]]
walls = ["w3"]
type = "rotate"
centre_m = [0, 0, 0]
axis = [0, 0, 1]
rate_rpm = 1
<<[[motion]]>>
[[motion]]
walls = ["w3"]
type = "oscillate"
amplitude_m = [0, 0, 0]
frequency_hz = 1
<<[[motion]]>>
[[motion]]
walls = ["w3"]
type = "table"
points = [{time_s = 0, displacement_m = [0, 0, 0] <<,[[motion]] points>>}]
<<[[motion]]>>
[[region]]
name = "r"
axis_start_m = [0, 0, 0]
axis_end_m = [0, 0, 1]
radius_m = 1
<<[[region]]>>
[fill]
lower_m = [0, 0, 0]
upper_m = [1, 1, 1]
<<[fill]>>
[[fill.layer]]
mass_kg = 1
mixture = [{material = "a", mass_fraction = 1, sizes = [
  {diameter_m = 1, mass_fraction = 0.5 <<,sizes = [{...}, ...]>>},
  {lower_diameter_m = 1, upper_diameter_m = 2, mass_fraction = 0.5 <<,sizes = [{...}, ...]>>}
] <<,mixture>>}]
<<[[fill.layer]]>>
[[fill.layer]]
mass_kg = 1
material = "a"
sizes = {sieves_m = [1, 2], mass_percent = [100] <<,sizes = {...}>>}
<<[[fill.layer]]>>
[[rain]]
name = "n"
mass_kg = 1
mass_rate_kg_s = 1
lower_m = [0, 0, 0]
upper_m = [1, 1, 1]
material = "a"
sizes = {distribution = "log-normal", median_diameter_m = 1, geometric_sd = 2, lower_diameter_m = 1, upper_diameter_m = 2 <<,sizes = {...}>>}
<<[[rain]]>>
[[rain]]
name = "m"
mass_kg = 1
mass_rate_kg_s = 1
lower_m = [0, 0, 0]
upper_m = [1, 1, 1]
mixture = [{material = "a", mass_fraction = 1, sizes = {distribution = "rosin-rammler", scale_diameter_m = 1, spread = 2, lower_diameter_m = 1, upper_diameter_m = 2 <<,sizes = {...}>>}}]
<<[[rain]]>>
[[particle_table]]
file = "/p.csv"
<<[[particle_table]]>>
[[particle]]
material = "a"
radius_m = 1
position_m = [0, 0, 0]
<<[[particle]]>>
[[stage]]
name = "s"
duration_s = 1
at_rest = {window_s = 1 <<,[[stage]] at_rest>>}
flow_ends = {region = "r" <<,[[stage]] flow_ends>>}
coefficients = {restitution = 0.5, mu_s = 0, mu_r = 0 <<,[[stage]] coefficients>>}
<<[[stage]]>>
[output]
<<[output]>>
)";

/// The document with the mark number `at` made an unknown key, all others taken out.
std::string with_unknown_key(int at, std::string& table) {
  const std::string text = kEverything;
  const std::regex mark("<<(,?)([^>]*)>>");
  std::string out;
  auto from = text.cbegin();
  int number = 0;
  for (auto m = std::sregex_iterator(text.begin(), text.end(), mark); m != std::sregex_iterator();
       ++m) {
    out.append(from, (*m)[0].first);
    if (number++ == at) {
      table = (*m)[2];
      out += (*m)[1].str() + " qqqqqqqqqqqq = 1";
    }
    from = (*m)[0].second;
  }
  return out.append(from, text.cend());
}

Names split(std::string list) {
  list = std::regex_replace(list, std::regex(" and "), ", ");
  Names names;
  const std::regex word("[a-z0-9_]+");
  for (auto m = std::sregex_iterator(list.begin(), list.end(), word); m != std::sregex_iterator();
       ++m)
    names.insert(m->str());
  return names;
}

/// By table, the keys that the reader says it knows when it meets one that it does not.
std::map<std::string, Names> accepted_keys() {
  std::map<std::string, Names> accepted;
  for (int at = 0;; ++at) {
    std::string table = "(none)";
    const std::string text = with_unknown_key(at, table);
    if (table == "(none)") return accepted;
    try {
      parse_case(text, "everything");
      ADD_FAILURE() << "an unknown key of " << table << " was accepted";
    } catch (const InputError& error) {
      const std::string message = error.what();
      const std::string words = "known here: ";
      const auto place = message.find(words);
      EXPECT_NE(place, std::string::npos) << table << ": " << message;
      if (place != std::string::npos)
        accepted[table].merge(split(message.substr(place + words.size())));
    }
  }
}

TEST(CaseKeys, AreExactlyThoseThatTheReaderAccepts) {
  std::map<std::string, Names> listed_keys;
  for (const CaseKey& key : case_keys()) {
    const std::string table(key.table);
    if (table == "[parameters]") {  // whose names are free
      listed_keys[""].insert("parameters");
      continue;
    }
    EXPECT_TRUE(listed_keys[table].insert(std::string(key.key)).second)
        << table << " " << key.key << " stands twice";
    const bool is_first_level =
        table.starts_with("[") && table.ends_with("]") && table.find('.') == std::string::npos;
    if (is_first_level) listed_keys[""].merge(split(table));
  }
  const std::map<std::string, Names> accepted = accepted_keys();
  for (const auto& [table, names] : accepted) EXPECT_EQ(listed_keys[table], names) << table;
  for (const auto& [table, names] : listed_keys)
    EXPECT_TRUE(accepted.contains(table)) << "no document of this test has a table " << table;
}

TEST(CaseKeys, AreAllInTheDocumentation) {
  const std::string text = read_file(REPOSE_SOURCE_DIR "/docs/methods/dem.md");
  for (const CaseKey& key : case_keys())
    EXPECT_NE(text.find("`" + std::string(key.key) + "`"), std::string::npos)
        << key.table << " " << key.key << " is not in docs/methods/dem.md";
}

TEST(CaseKeys, TextFitsItsColumnsAndHasEachKeyAndUnit) {
  const std::string text = case_keys_text(100);
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = text.find('\n', from);
    EXPECT_LE(end - from, 100u) << text.substr(from, end - from);
    from = end + 1;
  }
  for (const CaseKey& key : case_keys()) {
    EXPECT_NE(text.find("  " + std::string(key.key) + " "), std::string::npos) << key.key;
    EXPECT_FALSE(key.unit.empty()) << key.key;
    EXPECT_FALSE(key.meaning.empty()) << key.table << " " << key.key;
  }
}

}  // namespace
}  // namespace repose::scene

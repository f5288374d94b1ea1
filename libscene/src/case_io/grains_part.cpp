// Clumps, mixtures and sizes in a case file.
#include <cmath>

#include "case_io/parts.hpp"
#include "repose/base/text.hpp"

namespace repose::scene {
namespace {

const Allowed kFraction{.lower = 0.0, .upper = 1.0, .open_lower = true};

SizeClass read_size_class(const TomlTable& table) {
  SizeClass size;
  if (table.has("diameter_m")) {
    size.lower_diameter_m = table.number("diameter_m", kPositive);
    size.upper_diameter_m = size.lower_diameter_m;
  } else {
    size.lower_diameter_m = table.number("lower_diameter_m", kPositive);
    size.upper_diameter_m = table.number("upper_diameter_m", kPositive);
  }
  size.mass_fraction = table.number_or("mass_fraction", 1.0, kFraction);
  return size;
}

/// n percentages of mass between n + 1 ascending sieves; a sieve that kept nothing is no class.
std::vector<SizeClass> read_sieves(const TomlTable& table) {
  const std::vector<double> edges = table.numbers("sieves_m", kPositive);
  const std::vector<double> percent = table.numbers("mass_percent", kNonNegative);
  if (edges.size() != percent.size() + 1)
    table.fail("sieves_m", "has " + std::to_string(edges.size()) + " openings for " +
                               std::to_string(percent.size()) +
                               " masses; give one opening more than mass_percent has numbers");
  double sum = 0.0;
  for (double share : percent) sum += share;
  if (std::abs(sum - 100.0) > 1e-7)
    table.fail("mass_percent", "sums to " + shortest(sum) + "; it must sum to 100");
  std::vector<SizeClass> classes;
  for (std::size_t k = 0; k < percent.size(); ++k) {
    if (!(edges[k + 1] > edges[k]))
      table.fail("sieves_m", shortest(edges[k + 1]) + " follows " + shortest(edges[k]) +
                                 "; openings must ascend");
    if (percent[k] > 0.0) classes.push_back({edges[k], edges[k + 1], percent[k] / 100.0});
  }
  return classes;
}

Sizes read_distribution(const TomlTable& table) {
  if (table.choice("distribution", {"log-normal", "rosin-rammler"}) == "log-normal")
    return LogNormal{
        .median_diameter_m = table.number("median_diameter_m", kPositive),
        .geometric_sd = table.number("geometric_sd", {.lower = 1.0, .open_lower = true}),
        .lower_diameter_m = table.number("lower_diameter_m", kPositive),
        .upper_diameter_m = table.number("upper_diameter_m", kPositive)};
  return RosinRammler{.scale_diameter_m = table.number("scale_diameter_m", kPositive),
                      .spread = table.number("spread", kPositive),
                      .lower_diameter_m = table.number("lower_diameter_m", kPositive),
                      .upper_diameter_m = table.number("upper_diameter_m", kPositive)};
}

Sizes read_sizes(const TomlTable& table) {
  if (table.is_table("sizes")) {
    const TomlTable sizes = table.table("sizes");
    if (sizes.has("sieves_m")) return read_sieves(sizes);
    return read_distribution(sizes);
  }
  std::vector<SizeClass> classes;
  for (const TomlTable& size : table.tables("sizes")) classes.push_back(read_size_class(size));
  return classes;
}

Grains read_kind(const TomlTable& table) {
  Grains kind;
  kind.material = table.text("material");
  kind.clump = table.text_or("clump", "");
  kind.sizes = read_sizes(table);
  return kind;
}

struct SizesWriter {
  CaseText& out;
  void operator()(const std::vector<SizeClass>& classes) const {
    out.text += "sizes = [\n";
    for (const SizeClass& size : classes)
      out.text += "  {lower_diameter_m = " + number_text(size.lower_diameter_m) +
                  ", upper_diameter_m = " + number_text(size.upper_diameter_m) +
                  ", mass_fraction = " + number_text(size.mass_fraction) + "},\n";
    out.text += "]\n";
  }
  void operator()(const LogNormal& sizes) const {
    out.raw("sizes", "{distribution = \"log-normal\", median_diameter_m = " +
                         number_text(sizes.median_diameter_m) +
                         ", geometric_sd = " + number_text(sizes.geometric_sd) + cut_offs(sizes));
  }
  void operator()(const RosinRammler& sizes) const {
    out.raw("sizes", "{distribution = \"rosin-rammler\", scale_diameter_m = " +
                         number_text(sizes.scale_diameter_m) +
                         ", spread = " + number_text(sizes.spread) + cut_offs(sizes));
  }
  template <class Distribution>
  static std::string cut_offs(const Distribution& sizes) {
    return ", lower_diameter_m = " + number_text(sizes.lower_diameter_m) +
           ", upper_diameter_m = " + number_text(sizes.upper_diameter_m) + "}";
  }
};

void write_kind(CaseText& out, const Grains& kind) {
  out.put("material", kind.material);
  out.put_if_any("clump", kind.clump);
  std::visit(SizesWriter{out}, kind.sizes);
}

}  // namespace

ClumpShape read_clump(const TomlTable& table) {
  ClumpShape clump;
  clump.name = table.text("name");
  for (const TomlTable& sphere : table.tables("spheres"))
    clump.spheres.push_back({vector3(sphere, "position"), sphere.number("radius", kPositive)});
  return clump;
}

std::vector<Grains> read_mixture(const TomlTable& table) {
  if (!table.has("mixture")) return {read_kind(table)};
  for (const char* key : {"material", "clump", "sizes"})
    if (table.has(key)) table.fail(key, "stands beside mixture; give it in each kind of mixture");
  std::vector<Grains> mixture;
  for (const TomlTable& item : table.tables("mixture")) {
    mixture.push_back(read_kind(item));
    mixture.back().mass_fraction = item.number("mass_fraction", {.lower = 0.0, .upper = 1.0});
  }
  return mixture;
}

void write_clump(CaseText& out, const ClumpShape& clump) {
  out.heading("[[clump]]");
  out.put("name", clump.name);
  out.text += "spheres = [\n";
  for (const ClumpShape::Sphere& sphere : clump.spheres)
    out.text += "  {position = " + vector_text(sphere.position) +
                ", radius = " + number_text(sphere.radius) + "},\n";
  out.text += "]\n";
}

void write_mixture(CaseText& out, const std::vector<Grains>& mixture, const std::string& heading) {
  if (mixture.size() == 1 && mixture.front().mass_fraction == 1.0) {
    write_kind(out, mixture.front());
    return;
  }
  for (const Grains& kind : mixture) {
    out.text += heading + "\n";
    out.put("mass_fraction", kind.mass_fraction);
    write_kind(out, kind);
  }
}

}  // namespace repose::scene

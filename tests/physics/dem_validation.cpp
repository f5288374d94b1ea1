// Runs the long forms of all checks and writes the validation page.
// dem_validation OUTPUT.md [GROUP...]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iostream>

#include "check.hpp"

namespace {

using namespace repose::physics;

std::string demand_text(const Check& c) {
  switch (c.demand) {
    case Demand::near:
      return c.tolerance == 0.0 ? fmt::format("{:.5g} exactly", c.reference)
                                : fmt::format("{:.5g} ± {:.2g}", c.reference, c.tolerance);
    case Demand::at_most:
      return fmt::format("≤ {:.5g}", c.reference + c.tolerance);
    case Demand::at_least:
      return fmt::format("≥ {:.5g}", c.reference - c.tolerance);
    case Demand::report:
      return "–";
  }
  return "";
}

const char* verdict(const Check& c) {
  if (c.demand == Demand::report) return "";
  return c.passed() ? "met" : "**missed**";
}

std::string row(const Check& c) {
  return fmt::format("| {} | {:.6g}{}{} | {} | {} |\n", c.requirement, c.result,
                     c.unit.empty() ? "" : " ", c.unit, demand_text(c), verdict(c));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::cerr << "usage: dem_validation OUTPUT.md [GROUP...]\n";
    return 2;
  }
  const auto wanted = [&](const Group& group) {
    return argc == 2 ||
           std::any_of(argv + 2, argv + argc, [&](const char* a) { return group.id == a; });
  };
  std::string body, misses, left_out;
  int met = 0, missed = 0;
  for (const Group& group : all_groups()) {
    if (!wanted(group)) {
      left_out += (left_out.empty() ? "" : ", ") + group.id;
      continue;
    }
    const auto start = std::chrono::steady_clock::now();
    const std::vector<Check> checks = group.run(Extent::full);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::cerr << fmt::format("{}: {} checks, {:.1f} s\n", group.id, checks.size(), seconds);
    body += fmt::format(
        "\n## {}\n\n{}\n\n| requirement | result | reference | verdict |\n|---|---|---|---|\n",
        group.title, group.note);
    for (const Check& c : checks) {
      body += row(c);
      if (c.demand == Demand::report) continue;
      ++(c.passed() ? met : missed);
      if (!c.passed()) misses += fmt::format("- {}: {}\n", group.title, c.requirement);
    }
  }
  std::ofstream out(argv[1]);
  out << "# The engine's physics, checked\n\n"
         "Written by `scripts/validate_dem`; every figure below is computed by it. Short forms of "
         "the same "
         "checks run in CI (`ctest -L physics`).\n\n"
      << fmt::format("{} requirements met, {} missed.\n", met, missed)
      << (left_out.empty() ? "" : "\nNot run this time: " + left_out + ".\n")
      << (misses.empty() ? "" : "\nMissed:\n\n" + misses) << body;
  if (!out) {
    std::cerr << "cannot write " << argv[1] << '\n';
    return 6;
  }
  return missed == 0 ? 0 : 1;
}

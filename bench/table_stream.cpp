// A table larger than it may cost in memory: written in blocks, then read by column.
// repose_table_stream FILE.h5 [ROWS] [COLUMNS]: 10 million rows of 20 columns by default, 1.6 GB.
#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "repose/base/random.hpp"
#include "repose/table/reader.hpp"
#include "repose/table/writer.hpp"

namespace {

using namespace repose;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

long peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024;
}

void report(const char* what, double gigabytes, double seconds) {
  fmt::print("{:<24}{:6.1f} s {:8.0f} MB/s   peak so far {} MB\n", what, seconds,
             1e3 * gigabytes / seconds, peak_megabytes());
}

std::string column_name(std::size_t j) {
  return fmt::format("c{}", j + 1);
}

/// Random numbers, which nothing compresses.
table::Table block_of(std::size_t rows, std::size_t columns, RandomStream& random) {
  table::Table block;
  for (std::size_t j = 0; j < columns; ++j) {
    std::vector<double> values(rows);
    for (double& value : values) value = random.uniform();
    block.add({.name = column_name(j), .values = std::move(values)});
  }
  return block;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "repose_table_stream FILE.h5 [ROWS] [COLUMNS]\n");
    return 2;
  }
  const table::Location place{argv[1], ""};
  const std::size_t rows = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 10'000'000;
  const std::size_t columns = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 20;
  const double gigabytes = 8e-9 * static_cast<double>(rows * columns);
  constexpr std::size_t kBlock = 50'000;
  fmt::print("{} rows of {} columns, {:.2f} GB; before: {} MB\n", rows, columns, gigabytes,
             peak_megabytes());

  RandomStream random(1);
  double sum = 0.0;
  auto start = Clock::now();
  {
    table::TableWriter writer(place, block_of(0, columns, random));
    while (writer.rows() < rows) {
      const auto block = block_of(std::min(kBlock, rows - writer.rows()), columns, random);
      for (const double value : block.numbers("c1")) sum += value;
      writer.append(block);
    }
    writer.finish();
  }
  report("drawn and written", gigabytes, seconds_since(start));

  start = Clock::now();
  const table::TableReader reader(place);
  double back = 0.0;
  for (std::size_t j = 0; j < columns; ++j)
    reader.for_each_block(column_name(j), [&](std::size_t, const table::Values& block) {
      for (const double value : std::get<std::vector<double>>(block))
        if (j == 0) back += value;
    });
  report("read, all columns", gigabytes, seconds_since(start));
  if (back != sum || reader.rows() != rows) {
    fmt::print(stderr, "what was read is not what was written\n");
    return 1;
  }
  return 0;
}

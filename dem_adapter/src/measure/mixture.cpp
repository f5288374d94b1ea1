#include "repose/dem_adapter/mixture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"

namespace repose::dem_adapter {
namespace {

using scene::Vec3;

constexpr double kMostBinsAcross = 1e6;

/// `x` moved by whole periods next to `reference`.
Vec3 nearest_image(const scene::Case& scene, Vec3 x, const Vec3& reference) {
  const bool is_periodic[3] = {scene.periodic.x, scene.periodic.y, scene.periodic.z};
  for (int d = 0; d < 3; ++d) {
    const double period = scene.upper_m[d] - scene.lower_m[d];
    if (is_periodic[d]) x[d] -= period * std::round((x[d] - reference[d]) / period);
  }
  return x;
}

/// `x` moved by whole periods into the domain.
Vec3 wrapped(const scene::Case& scene, Vec3 x) {
  const bool is_periodic[3] = {scene.periodic.x, scene.periodic.y, scene.periodic.z};
  for (int d = 0; d < 3; ++d) {
    const double period = scene.upper_m[d] - scene.lower_m[d];
    if (is_periodic[d]) x[d] -= period * std::floor((x[d] - scene.lower_m[d]) / period);
  }
  return x;
}

struct Grain {
  Vec3 first = Vec3::Zero();  ///< its first sphere
  Vec3 moment = Vec3::Zero();
  double mass_kg = 0.0;
  std::int64_t material = 0;
};

std::map<std::int64_t, Grain> grains_of(const scene::Snapshot& snapshot, const scene::Case& scene) {
  std::map<std::int64_t, Grain> grains;
  for (std::size_t i = 0; i < snapshot.size(); ++i) {
    auto [at, is_new] = grains.try_emplace(snapshot.body[i]);
    Grain& grain = at->second;
    if (is_new) grain.first = snapshot.position[i];
    grain.moment += snapshot.mass_kg[i] * nearest_image(scene, snapshot.position[i], grain.first);
    grain.mass_kg += snapshot.mass_kg[i];
    grain.material = snapshot.material[i];
  }
  return grains;
}

std::array<int, 3> cell_of(const Vec3& x, const Grid& grid) {
  const Vec3 d = x - grid.origin;
  const auto along = [&](double distance) {
    const double cell = std::floor(distance / grid.size);
    if (!(std::abs(cell) < kMostBinsAcross))
      throw InputError(
          fmt::format("bins of {} m would number more than {} from end to end; give larger ones",
                      grid.size, static_cast<int>(kMostBinsAcross)));
    return static_cast<int>(cell);
  };
  switch (grid.kind) {
    case GridKind::x:
      return {along(d.x()), 0, 0};
    case GridKind::y:
      return {along(d.y()), 0, 0};
    case GridKind::vertical:
      return {along(d.z()), 0, 0};
    case GridKind::radial:
      return {along(std::hypot(d.x(), d.y())), 0, 0};
    case GridKind::circumferential: {
      const int sectors = static_cast<int>(std::lround(360.0 / grid.size));
      const double turn = std::atan2(d.y(), d.x()) / (2.0 * std::numbers::pi);  // -1/2 to 1/2
      const int sector = static_cast<int>(std::floor((turn < 0.0 ? turn + 1.0 : turn) * sectors));
      return {std::min(sector, sectors - 1), 0, 0};
    }
    case GridKind::cubic:
      return {along(d.x()), along(d.y()), along(d.z())};
  }
  return {};
}

void check(const Grid& grid) {
  if (!(grid.size > 0.0 && std::isfinite(grid.size)))
    throw InputError(fmt::format("the size of a bin is {}; it must be above 0", grid.size));
  if (grid.kind != GridKind::circumferential) return;
  const double sectors = 360.0 / grid.size;
  if (!(std::abs(sectors - std::round(sectors)) < 1e-9 * sectors) || sectors < 1.5 ||
      sectors > kMostBinsAcross)
    throw InputError(
        fmt::format("sectors of {} degrees do not divide the circle; give e.g. 45", grid.size));
}

}  // namespace

Mixture mixture_of(const scene::Snapshot& snapshot, const scene::Case& scene,
                   const scene::Region& where) {
  std::vector<int> index(snapshot.materials.size(), -1);
  Mixture mixture;
  for (const auto& [body, grain] : grains_of(snapshot, scene)) {
    const Vec3 center = wrapped(scene, grain.moment / grain.mass_kg);
    if (!is_inside(where, center)) continue;
    const auto material = static_cast<std::size_t>(grain.material);
    const std::string& name = snapshot.materials.at(material);
    if (index[material] < 0) {
      index[material] = static_cast<int>(mixture.components.size());
      mixture.components.push_back(name);
    }
    const auto known = static_cast<std::size_t>(material_index(scene, name));
    mixture.component.push_back(index[material]);
    mixture.position.push_back(center);
    mixture.mass_kg.push_back(grain.mass_kg);
    mixture.volume_m3.push_back(grain.mass_kg / scene.materials[known].density_kg_m3);
  }
  if (mixture.size() == 0)
    throw InputError(
        fmt::format("none of the {} spheres has its grain's centre in the place to be "
                    "measured; widen it",
                    snapshot.size()));
  return mixture;
}

double reference_diameter_m(const Mixture& mixture) {
  double sum = 0.0;
  for (std::size_t k = 0; k < mixture.components.size(); ++k) {
    std::vector<std::pair<double, double>> grains;  // volume, mass
    double total = 0.0, below = 0.0;
    for (std::size_t i = 0; i < mixture.size(); ++i) {
      if (mixture.component[i] != static_cast<int>(k)) continue;
      grains.emplace_back(mixture.volume_m3[i], mixture.mass_kg[i]);
      total += mixture.mass_kg[i];
    }
    std::sort(grains.begin(), grains.end());
    std::size_t i = 0;
    while (i + 1 < grains.size() && (below += grains[i].second) < 0.5 * total) ++i;
    sum += std::cbrt(6.0 / std::numbers::pi * grains[i].first);
  }
  return sum / static_cast<double>(mixture.components.size());
}

const char* to_string(GridKind kind) {
  constexpr const char* kNames[] = {"x", "y", "vertical", "radial", "circumferential", "cubic"};
  return kNames[static_cast<std::size_t>(kind)];
}

GridKind grid_kind(const std::string& name) {
  std::vector<std::string> names;
  for (const GridKind kind : {GridKind::x, GridKind::y, GridKind::vertical, GridKind::radial,
                              GridKind::circumferential, GridKind::cubic}) {
    if (name == to_string(kind)) return kind;
    names.emplace_back(to_string(kind));
  }
  throw InputError(fmt::format("there is no grid '{}'; choose {}", name, listed(names)));
}

const Eigen::MatrixXd& Bins::amount(Basis basis) const {
  return basis == Basis::number ? number : basis == Basis::mass ? mass_kg : volume_m3;
}

Bins bins_of(const Mixture& mixture, const Grid& grid) {
  check(grid);
  std::map<std::array<int, 3>, Eigen::Index> row;
  std::vector<std::array<int, 3>> cell(mixture.size());
  for (std::size_t i = 0; i < mixture.size(); ++i)
    row[cell[i] = cell_of(mixture.position[i], grid)] = 0;
  Bins bins;
  bins.components = mixture.components;
  for (auto& [key, index] : row) {
    index = static_cast<Eigen::Index>(bins.cell.size());
    bins.cell.push_back(key);
  }
  const auto rows = static_cast<Eigen::Index>(bins.cell.size());
  const auto columns = static_cast<Eigen::Index>(mixture.components.size());
  bins.number = bins.mass_kg = bins.volume_m3 = Eigen::MatrixXd::Zero(rows, columns);
  for (std::size_t i = 0; i < mixture.size(); ++i) {
    const Eigen::Index r = row.at(cell[i]), k = mixture.component[i];
    bins.number(r, k) += 1.0;
    bins.mass_kg(r, k) += mixture.mass_kg[i];
    bins.volume_m3(r, k) += mixture.volume_m3[i];
  }
  return bins;
}

Eigen::MatrixXd pixels_in_slices(const View& view, SliceDirection direction, int count) {
  if (count < 2)
    throw InputError(
        fmt::format("{} slices cannot show segregation; at least 2 are needed", count));
  const bool across = direction == SliceDirection::horizontal;
  const int width = view.picture.width, height = view.picture.height;
  int first = across ? width : height, last = -1;
  const auto for_each_pixel = [&](auto&& use) {
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column)
        if (const auto label = view.label[view.picture.index(column, row)]; label != kBackground)
          use(across ? column : row, static_cast<Eigen::Index>(label));
  };
  for_each_pixel([&](int at, Eigen::Index) {
    first = std::min(first, at);
    last = std::max(last, at);
  });
  Eigen::MatrixXd pixels =
      Eigen::MatrixXd::Zero(count, static_cast<Eigen::Index>(view.components.size()));
  const std::int64_t extent = last - first + 1;
  for_each_pixel([&](int at, Eigen::Index label) {
    pixels(static_cast<Eigen::Index>((at - first) * static_cast<std::int64_t>(count) / extent),
           label) += 1.0;
  });
  Eigen::Index used = 0;
  for (Eigen::Index r = 0; r < count; ++r)
    if (pixels.row(r).sum() > 0.0) pixels.row(used++) = pixels.row(r).eval();
  return pixels.topRows(used);
}

}  // namespace repose::dem_adapter

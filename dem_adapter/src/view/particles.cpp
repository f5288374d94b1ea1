// From particles to a view: orthographic projection, the nearest sphere hides the others.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "repose/base/error.hpp"
#include "repose/dem_adapter/view.hpp"

namespace repose::dem_adapter {
namespace {

constexpr double kMostPixelsSeen = 4e6;
constexpr double kPixelsAcrossSmallest = 10.0;
constexpr Rgb kSky{255, 255, 255};
/// Of materials in turn: told apart by colour-blind readers as well [OkabeIto2008].
constexpr Rgb kColors[] = {{230, 159, 0},  {86, 180, 233}, {0, 158, 115},
                           {240, 228, 66}, {0, 114, 178},  {213, 94, 0}};

struct Seen {
  std::vector<Disc> discs;
  std::vector<double> depth_m;  ///< of the centres, away from the camera
  std::vector<std::int16_t> material;
};

Seen seen_of(const scene::Snapshot& snapshot, const ParticleViewOptions& options) {
  const bool along_y = options.direction == ViewDirection::along_y;
  Seen seen;
  for (std::size_t i = 0; i < snapshot.size(); ++i) {
    if (snapshot.velocity[i].norm() > options.fastest_m_s) continue;
    const auto& x = snapshot.position[i];
    if (options.region && !scene::is_inside(*options.region, x)) continue;
    const Disc disc{along_y ? x.x() : x.y(), x.z(), snapshot.radius_m[i]};
    const auto outside = [&](double at, const std::optional<double>& from,
                             const std::optional<double>& to) {
      return (from && at < *from) || (to && at > *to);
    };
    if (outside(disc.x_m, options.left_m, options.right_m) ||
        outside(disc.z_m, options.bottom_m, options.top_m))
      continue;
    seen.discs.push_back(disc);
    seen.depth_m.push_back(along_y ? x.y() : -x.x());
    seen.material.push_back(static_cast<std::int16_t>(snapshot.material[i]));
  }
  if (seen.discs.empty())
    throw InputError(fmt::format(
        "none of the {} spheres is seen: centres must lie within the given ends and be slower than "
        "{} m/s",
        snapshot.size(), options.fastest_m_s));
  return seen;
}

struct Frame {
  double left, right, bottom, top;
  double smallest, largest;  ///< radius
};

Frame frame_of(const std::vector<Disc>& discs, const ParticleViewOptions& options) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Frame f{kFar, -kFar, kFar, -kFar, kFar, 0.0};
  for (const Disc& d : discs) {
    f.left = std::min(f.left, d.x_m - d.radius_m);
    f.right = std::max(f.right, d.x_m + d.radius_m);
    f.bottom = std::min(f.bottom, d.z_m - d.radius_m);
    f.top = std::max(f.top, d.z_m + d.radius_m);
    f.smallest = std::min(f.smallest, d.radius_m);
    f.largest = std::max(f.largest, d.radius_m);
  }
  f.left = options.left_m.value_or(f.left);
  f.right = options.right_m.value_or(f.right);
  f.bottom = options.bottom_m.value_or(f.bottom);
  return f;
}

/// Labels the pixels whose centre is in a disc, nearest sphere first.
void draw(const Seen& seen, View& view) {
  const Picture& picture = view.picture;
  std::vector<double> nearest(picture.pixels.size(), std::numeric_limits<double>::infinity());
  const double top = view.bottom_m + picture.height * view.pixel_m;
  const auto first = [](double at) { return std::max(static_cast<int>(std::ceil(at - 0.5)), 0); };
  for (std::size_t k = 0; k < seen.discs.size(); ++k) {
    const Disc& disc = seen.discs[k];
    const double r = disc.radius_m, x = disc.x_m - view.left_m, y = top - disc.z_m;
    for (int row = first((y - r) / view.pixel_m);
         row < picture.height && (row + 0.5) * view.pixel_m <= y + r; ++row)
      for (int column = first((x - r) / view.pixel_m);
           column < picture.width && (column + 0.5) * view.pixel_m <= x + r; ++column) {
        const double dx = (column + 0.5) * view.pixel_m - x, dy = (row + 0.5) * view.pixel_m - y;
        const double bulge = r * r - dx * dx - dy * dy;
        if (bulge < 0.0) continue;
        const double depth = seen.depth_m[k] - std::sqrt(bulge);
        const std::size_t i = picture.index(column, row);
        if (depth >= nearest[i]) continue;
        nearest[i] = depth;
        view.label[i] = seen.material[k];
        const double shade = 0.55 + 0.45 * std::sqrt(bulge) / r;
        const Rgb& color = kColors[static_cast<std::size_t>(seen.material[k]) % std::size(kColors)];
        for (std::size_t channel = 0; channel < 3; ++channel)
          view.picture.pixels[i][channel] =
              static_cast<std::uint8_t>(std::lround(shade * color[channel]));
      }
  }
}

}  // namespace

View view_of_particles(const scene::Snapshot& snapshot, const ParticleViewOptions& options) {
  const Seen seen = seen_of(snapshot, options);
  const Frame frame = frame_of(seen.discs, options);
  const double width = frame.right - frame.left, height = frame.top - frame.bottom;
  double pixel = options.pixel_m > 0.0 ? options.pixel_m
                                       : std::max(2.0 * frame.smallest / kPixelsAcrossSmallest,
                                                  std::sqrt(width * height / kMostPixelsSeen));
  if (!(width > 0.0 && height > 0.0) ||
      width / pixel * (height / pixel) > static_cast<double>(kMostPixels))
    throw InputError(fmt::format("a view of {} x {} m in pixels of {} m is empty or too large",
                                 width, height, pixel));
  View view;
  view.pixel_m = pixel;
  view.largest_grain_m = 2.0 * frame.largest;
  view.left_m = frame.left;
  view.bottom_m = frame.bottom;
  view.picture = Picture(std::max(static_cast<int>(std::floor(width / pixel + 1e-9)), 1),
                         std::max(static_cast<int>(std::ceil(height / pixel - 1e-9)), 1), kSky);
  view.components = snapshot.materials;
  view.label.assign(view.picture.pixels.size(), kBackground);
  view.profile = silhouette(seen.discs, frame.left, frame.left + view.picture.width * pixel, pixel);
  draw(seen, view);
  return view;
}

}  // namespace repose::dem_adapter

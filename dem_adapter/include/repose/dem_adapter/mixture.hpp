// The grains of a mixture and what lies in the bins of a grid: what indices of segregation are
// made of.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "repose/dem_adapter/view.hpp"
#include "repose/scene/case.hpp"
#include "repose/scene/run_records.hpp"

namespace repose::dem_adapter {

/// Grains, one an entry; a clump is one grain at its centre of mass.
struct Mixture {
  std::vector<std::string> components;  ///< each has at least one grain
  std::vector<int> component;           ///< index into `components`
  std::vector<scene::Vec3> position;    ///< m
  std::vector<double> mass_kg;
  std::vector<double> volume_m3;  ///< of solid
  std::size_t size() const { return component.size(); }
};

/// The grains of a snapshot of `scene` whose centres lie in the region. Volumes are masses over the
/// materials' densities. Clumps that lie across a periodic side are put together. Throws InputError
/// if there are none or a material is not one of the case.
Mixture mixture_of(const scene::Snapshot& snapshot, const scene::Case& scene,
                   const scene::Region& where);

/// Mean over components of the diameter below which half of a component's mass lies (that of the
/// sphere of the grain's volume) [Hadi2026, section 6.2.3, where bins are ten of it].
double reference_diameter_m(const Mixture& mixture);

/// How space is cut into bins [Hadi2026, Figure 3.9].
enum class GridKind { x, y, vertical, radial, circumferential, cubic };
const char* to_string(GridKind kind);
/// The inverse; throws InputError that lists the kinds.
GridKind grid_kind(const std::string& name);

struct Grid {
  GridKind kind = GridKind::vertical;
  /// Edge of a bin: m; degrees for sectors (circumferential), which must divide 360.
  double size = 0.0;
  /// Corner of a bin; for rings and sectors a point of their axis, which is vertical.
  scene::Vec3 origin = scene::Vec3::Zero();
};

/// What a concentration is a share of [Hadi2026, Table A.1].
enum class Basis { number, mass, volume };

/// Contents of the bins that hold anything; bins x components.
struct Bins {
  std::vector<std::string> components;
  std::vector<std::array<int, 3>> cell;  ///< index of each bin; only the first counts except cubic
  Eigen::MatrixXd number, mass_kg, volume_m3;
  const Eigen::MatrixXd& amount(Basis basis) const;
};

/// Throws InputError if the size is not positive, sectors do not divide the circle, or there would
/// be more than a million bins from end to end.
Bins bins_of(const Mixture& mixture, const Grid& grid);

enum class SliceDirection { horizontal, vertical };

/// Pixels of each component in `count` slices of equal size between the ends of what is seen:
/// side by side (horizontal segregation) or one above the other (vertical) [Hadi2026, section
/// 5.2.3, Eq. 5.1]; bins x components. Slices without pixels are left out.
Eigen::MatrixXd pixels_in_slices(const View& view, SliceDirection direction, int count);

}  // namespace repose::dem_adapter

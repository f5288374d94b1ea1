// The draw-down test: layers in an upper box fall through a slot into a lower one, leaving a shear
// slope above and a heap below.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "repose/dem_adapter/measurement.hpp"
#include "repose/dem_adapter/scenario.hpp"
#include "repose/scene/case.hpp"
#include "repose/scene/run_output.hpp"

namespace repose::dem_adapter {

/// Front and back of the boxes: a periodic slice, or plane walls of the boxes' material.
enum class DrawdownFront { periodic, walls };

/// One of the granular materials.
struct DrawdownMaterial {
  std::string name;
  std::string symbol;  ///< one letter in coefficient names: mu_s_pp, mu_s_pg
  double density_kg_m3 = 0.0;
  double poissons_ratio = 0.25;
  double mass_share = 0.0;  ///< of the whole filling
  std::vector<scene::SizeClass> sizes;
  std::string clump{};  ///< a shipped shape, e.g. "sinter_3"; empty for spheres
};

/// x across, y through the thickness, z up; the upper floor with its slot is at z = 0, the lower
/// floor at z = -drop. Lengths in m.
struct Drawdown {
  double width_m = 0.20;       ///< inner width of the upper box
  double outlet_m = 0.060;     ///< width of the slot
  double thickness_m = 0.036;  ///< inner
  DrawdownFront front = DrawdownFront::periodic;
  double drop_m = 0.27;         ///< from the upper to the lower floor
  double lower_width_m = 0.50;  ///< inner width of the lower box
  double mass_per_thickness_kg_m = 66.0;

  std::vector<DrawdownMaterial> materials;
  std::vector<std::string>
      layers;  ///< material names, bottom first; a material's mass is shared equally
  double solid_fraction = 0.33;   ///< of the column before it falls
  double shear_modulus_pa = 2e6;  ///< of all particles; walls are 100 times stiffer
  double settle_s = 0.30;
  /// Of all pairs while the filling settles, in place of their own; then runs that differ only in
  /// coefficients share their filling.
  std::optional<scene::StageCoefficients> settle_coefficients{};
  double discharge_s = 1.8;  ///< at most; a discharge that has ended ends the run
  double time_step_rayleigh_fraction = 0.25;
  /// By name: mu_s_AB, mu_r_AB, c_r_AB for A, B among the symbols and g, the boxes. A pair of two
  /// different materials that is not given is the mean of its two own pairs [Hadi2026,
  /// section 5.3.7].
  std::map<std::string, double> coefficients;

  /// "quick": half-size periodic slice, about 1,230 spheres, seconds on a core. "delft-like": 0.15
  /// m thick with rough walls, of the family inferred for the thesis' rig, whose drawing is lost;
  /// about 10,800 spheres, minutes. Throws InputError for another name.
  static Drawdown preset(const std::string& name);
  /// `preset = "..."` and the keys that override it; documented in docs/how-to/drawdown.md.
  static Drawdown read(const TomlTable& table);

  /// Whether a case is a draw-down: has its walls and stages, so that measure() knows where to
  /// look.
  static bool is_of(const scene::Case& scene);

  std::string name() const { return "drawdown"; }
  /// Coefficients and the lengths, mass, modulus and time-step fraction above.
  std::vector<std::string> parameter_names() const;
  std::vector<std::string> kpi_names() const;
  scene::Case make_case(const ParameterValues& values, std::uint64_t seed) const;
  Measurement measure(const scene::Run& run) const;
};

}  // namespace repose::dem_adapter

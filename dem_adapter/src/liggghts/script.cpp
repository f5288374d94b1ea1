#include "script.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "repose/base/text.hpp"
#include "wall_moves.hpp"

namespace repose::dem_adapter::liggghts {
namespace {

using scene::Vec3;

constexpr double kHard_pa = 1e9, kSoft_pa = 5e6;  // beyond, LIGGGHTS wants to be told so
constexpr double kSkinRadii = 1.3;                // of the smallest sphere: fastest by experience
constexpr double kNoPair = 0.5;                   // for wall on wall, which never touch

constexpr const char* kColumns = "id x y z vx vy vz omegax omegay omegaz";
constexpr const char* kFormat = "\"%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\"";

std::int64_t steps_of(double duration_s, double dt) {
  return std::max<std::int64_t>(1, std::llround(duration_s / dt));
}

/// Rolling model and cohesion as the case has them; left out where all coefficients are 0.
std::string model_of(const scene::Case& scene) {
  bool rolls = false, sticks = false;
  for (const auto& pair : scene.pairs) {
    rolls = rolls || pair.mu_r > 0.0;
    sticks = sticks || pair.cohesion_energy_density_j_m3 > 0.0;
  }
  std::string model = "model hertz tangential history";
  if (sticks) model += " cohesion sjkr";
  if (!rolls) return model;
  if (scene.contact.rolling == scene::RollingModel::a) return model + " rolling_friction cdt";
  return model + (scene.contact.rolling_stiffness == scene::RollingStiffness::kt
                      ? " rolling_friction epsd2"
                      : " rolling_friction epsd");
}

/// A line of the script with values of all pairs of materials, row by row.
template <class Value>
std::string of_pairs(const scene::Case& scene, const char* property, Value value) {
  const int n = static_cast<int>(scene.materials.size());
  std::string text =
      fmt::format("fix p_{0} all property/global {0} peratomtypepair {1}", property, n);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const int pair = scene::pair_index(scene, a, b);
      text +=
          ' ' + shortest(pair < 0 ? kNoPair : value(scene.pairs[static_cast<std::size_t>(pair)]));
    }
  return text + '\n';
}

std::string materials_text(const scene::Case& scene) {
  std::string young = "fix p_E all property/global youngsModulus peratomtype";
  std::string poisson = "fix p_nu all property/global poissonsRatio peratomtype", limits;
  bool is_hard = false, is_soft = false;
  for (const auto& m : scene.materials) {
    young += ' ' + shortest(m.youngs_modulus_pa);
    poisson += ' ' + shortest(m.poissons_ratio);
    is_hard = is_hard || m.youngs_modulus_pa > kHard_pa;
    is_soft = is_soft || m.youngs_modulus_pa < kSoft_pa;
  }
  if (is_hard) limits += "hard_particles yes\n";
  if (is_soft) limits += "soft_particles yes\n";
  using Pair = scene::PairCoefficients;
  std::string text = limits + young + '\n' + poisson + '\n';
  text += of_pairs(scene, "coefficientRestitution", [](const Pair& p) { return p.restitution; });
  text += of_pairs(scene, "coefficientFriction", [](const Pair& p) { return p.mu_s; });
  text += of_pairs(scene, "coefficientRollingFriction", [](const Pair& p) { return p.mu_r; });
  text += of_pairs(scene, "coefficientRollingViscousDamping",
                   [](const Pair& p) { return p.rolling_damping; });
  text += of_pairs(scene, "cohesionEnergyDensity",
                   [](const Pair& p) { return p.cohesion_energy_density_j_m3; });
  return text;
}

std::string bound(double x) {
  return std::isfinite(x) ? shortest(x) : "INF";
}

std::string regions_text(const scene::Case& scene) {
  std::string text;
  for (std::size_t m = 0; m < scene.materials.size(); ++m)
    text += fmt::format("group of_{} type {}\n", m, m + 1);
  for (std::size_t r = 0; r < scene.regions.size(); ++r) {
    const scene::Region& region = scene.regions[r];
    const auto box =
        fmt::format("block {} {} {} {} {} {} units box", bound(region.lower.x()),
                    bound(region.upper.x()), bound(region.lower.y()), bound(region.upper.y()),
                    bound(region.lower.z()), bound(region.upper.z()));
    if (!region.cylinder) {
      text += fmt::format("region region_{} {}\n", r, box);
    } else {
      const auto& [start, end, radius] = *region.cylinder;
      Eigen::Index along = 0;
      (end - start).cwiseAbs().maxCoeff(&along);
      // LIGGGHTS names the other two coordinates in the order of x, y, z.
      const Eigen::Index u = along == 0 ? 1 : 0, v = along == 2 ? 1 : 2;
      text += fmt::format(
          "region box_{0} {1}\nregion round_{0} cylinder {2} {3} {4} {5} {6} {7} units box\n"
          "region region_{0} intersect 2 box_{0} round_{0}\n",
          r, box, "xyz"[along], shortest(start[u]), shortest(start[v]), shortest(radius),
          shortest(std::min(start[along], end[along])),
          shortest(std::max(start[along], end[along])));
    }
    text += fmt::format("variable mass_{0} equal mass(all,region_{0})\n", r);
    for (std::size_t m = 0; m < scene.materials.size(); ++m)
      text += fmt::format("variable mass_{0}_{1} equal mass(of_{1},region_{0})\n", r, m);
  }
  return text;
}

std::string row_text(const scene::Case& scene) {
  std::string text = "print \"@row ${now} ${energy} ${contacts}";
  for (std::size_t r = 0; r < scene.regions.size(); ++r) {
    text += fmt::format(" ${{mass_{}}}", r);
    for (std::size_t m = 0; m < scene.materials.size(); ++m)
      text += fmt::format(" ${{mass_{}_{}}}", r, m);
  }
  return text + "\"\n";
}

/// Writes the stages of a case.
class Stages {
 public:
  Stages(const scene::Case& scene, const std::vector<WallBody>& bodies, const Particles& particles)
      : scene_(scene),
        bodies_(bodies),
        particles_(particles),
        model_(model_of(scene)),
        row_(row_text(scene)),
        series_steps_(steps_of(scene.output.series_interval_s, particles.time_step_s)) {}

  std::string text() {
    put_walls();
    text_ += "run 0\n" + row_;
    for (std::size_t s = 0; s < scene_.stages.size(); ++s) add(s);
    return std::move(text_);
  }

 private:
  template <class... Arguments>
  void line(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    text_ += fmt::format(format, std::forward<Arguments>(arguments)...) + '\n';
  }

  bool is_there(const WallBody& body, int stage) const {
    return body.opened_in < 0 || body.opened_in > stage;
  }

  void put_walls() {
    for (const auto& body : bodies_) {
      if (body.plane)
        line("fix {} all wall/gran {} primitive type {} {}plane {}", body.id, model_,
             body.material + 1, "xyz"[body.plane->axis], shortest(body.plane->at_m));
      else
        line("fix {0} all mesh/surface file {0}.stl type {1}{2}", body.id, body.material + 1,
             body.smooth_deg > 0.0 ? " curvature " + shortest(body.smooth_deg) : "");
    }
    put_mesh_walls(-1);
  }

  /// LIGGGHTS has one fix for all meshes.
  void put_mesh_walls(int stage) {
    std::string meshes;
    int count = 0;
    for (const auto& body : bodies_)
      if (!body.plane && is_there(body, stage)) {
        meshes += ' ' + body.id;
        ++count;
      }
    if (count > 0)
      line("fix walls all wall/gran {} mesh n_meshes {} meshes{}", model_, count, meshes);
  }

  void open_walls(int stage) {
    const auto opens = [&](const WallBody& body) { return body.opened_in == stage; };
    if (std::none_of(bodies_.begin(), bodies_.end(), opens)) return;
    const auto opens_mesh = [&](const WallBody& body) { return opens(body) && !body.plane; };
    const bool meshes_change = std::any_of(bodies_.begin(), bodies_.end(), opens_mesh);
    if (meshes_change) line("unfix walls");
    for (const auto& body : bodies_) {
      if (!opens(body)) continue;
      for (const auto& move : moving_)
        if (move.second == body.id) line("unfix {}", move.first);
      std::erase_if(moving_, [&](const auto& move) { return move.second == body.id; });
      line("unfix {}", body.id);
    }
    if (meshes_change) put_mesh_walls(stage);
  }

  void begin_move(const MoveSpan& span, int stage) {
    for (const auto& body : bodies_) {
      if (body.motion != span.motion || !is_there(body, stage)) continue;
      const auto id = fmt::format("move_{}", ++moves_);
      line("fix {} all move/mesh mesh {} {}", id, body.id, span.style);
      moving_.emplace_back(id, body.id);
    }
  }

  void end_move(const MoveSpan& span) {
    for (const auto& body : bodies_) {
      if (body.motion != span.motion) continue;
      for (const auto& move : moving_)
        if (move.second == body.id) line("unfix {}", move.first);
      std::erase_if(moving_, [&](const auto& move) { return move.second == body.id; });
    }
  }

  void add(std::size_t s) {
    const scene::Stage& stage = scene_.stages[s];
    const auto spans = moves_of_stage(scene_, s);
    std::set<double> times;  // at which something changes within the stage
    for (const auto& span : spans)
      for (const double time : {span.begin_s, span.end_s})
        if (time > 0.0 && time < stage.duration_s) times.insert(time);
    times.insert(stage.duration_s);
    line("\n# stage {}", stage.name);
    open_walls(static_cast<int>(s));
    line("variable begin equal ${{now}}");
    line("variable moving string ${{now}}");
    line("variable reason string duration");
    if (stage.flow_ends) {
      line("variable initial equal ${{mass_{0}}}", region_of(*stage.flow_ends));
      line("variable mass_at_${{now}} string ${{mass_{0}}}", region_of(*stage.flow_ends));
    }
    double from_s = 0.0;
    int part = 0;
    for (const double to_s : times) {
      for (const auto& span : spans)
        if (part > 0 && span.end_s == from_s) end_move(span);
      for (const auto& span : spans)
        if (span.begin_s == from_s) begin_move(span, static_cast<int>(s));
      add_loop(s, part++, to_s);
      from_s = to_s;
    }
    line("label stage_{}_ends", s);
    line("print \"@end {} ${{now}} ${{reason}}\"", s);
    line("write_dump all custom stage_{}.dump {} modify sort id format {}", s, kColumns, kFormat);
    for (const auto& span : spans)  // those that end with the stage
      if (span.end_s == from_s) end_move(span);
  }

  std::size_t region_of(const scene::FlowEnds& flow) const {
    const auto named = [&](const scene::Region& region) { return region.name == flow.region; };
    return static_cast<std::size_t>(
        std::find_if(scene_.regions.begin(), scene_.regions.end(), named) - scene_.regions.begin());
  }

  /// From row to row until something changes or a criterion ends the stage.
  void add_loop(std::size_t s, int part, double to_s) {
    const scene::Stage& stage = scene_.stages[s];
    line("run 0");
    line("variable last equal ${{begin}}+{}", steps_of(to_s, particles_.time_step_s));
    line("label stage_{}_{}", s, part);
    line("variable grid equal (floor(v_now/{0})+1)*{0}", series_steps_);
    line("variable target equal (v_grid<v_last)*v_grid+(v_grid>=v_last)*v_last");
    line("variable portion equal v_target-v_now");
    line("run ${{portion}} pre no post no");
    text_ += row_;
    if (stage.at_rest) add_rest(*stage.at_rest, stage, s);
    if (stage.flow_ends) add_flow(*stage.flow_ends, stage, s);
    line("if \"${{now}} < ${{last}}\" then \"jump SELF stage_{}_{}\"", s, part);
  }

  void end_if(const char* condition, const char* reason, const scene::Stage& stage, std::size_t s) {
    line("variable ends equal \"(v_now-v_begin>={}) && {}\"",
         shortest(stage.minimum_s / particles_.time_step_s), condition);
    line("if \"${{ends}} == 1\" then \"variable reason string {}\" \"jump SELF stage_{}_ends\"",
         reason, s);
  }

  void add_rest(const scene::AtRest& rest, const scene::Stage& stage, std::size_t s) {
    line("if \"${{energy}} > {}\" then \"variable moving string ${{now}}\"",
         shortest(rest.kinetic_energy_ratio * particles_.weight_scale_j));
    end_if(fmt::format("(v_now-v_moving>={})", shortest(rest.window_s / particles_.time_step_s))
               .c_str(),
           "at_rest", stage, s);
  }

  /// The mass a window ago is that of the last row before, which is on the grid of rows or at the
  /// stage's beginning.
  void add_flow(const scene::FlowEnds& flow, const scene::Stage& stage, std::size_t s) {
    const auto r = region_of(flow);
    line("variable mass_at_${{now}} string ${{mass_{}}}", r);
    line("variable cut equal v_now-{}", shortest(flow.window_s / particles_.time_step_s));
    line("variable row equal floor(v_cut/{0})*{0}", series_steps_);
    line("variable from equal (v_row<v_begin)*v_begin+(v_row>=v_begin)*v_row");
    line("variable past equal v_mass_at_${{from}}");
    line("variable left equal v_initial-v_mass_{}", r);
    line("variable scale equal (v_left>0)*v_left+(v_left<=0)*v_initial");
    end_if(
        fmt::format("(v_cut>=v_begin) && (v_past-v_mass_{}<{}*v_scale)", r, shortest(flow.fraction))
            .c_str(),
        "flow_ended", stage, s);
  }

  const scene::Case& scene_;
  const std::vector<WallBody>& bodies_;
  const Particles& particles_;
  std::string model_, row_;
  std::int64_t series_steps_;
  std::string text_;
  int moves_ = 0;
  std::vector<std::pair<std::string, std::string>> moving_;  // fixes, and the bodies they move
};

}  // namespace

Box box_of(const scene::Case& scene, const std::vector<WallBody>& bodies) {
  Box box{scene.lower_m, scene.upper_m};
  const bool periodic[] = {scene.periodic.x, scene.periodic.y, scene.periodic.z};
  const Vec3 margin = 1e-3 * (scene.upper_m - scene.lower_m);
  for (const auto& body : bodies)
    for (const Vec3& corner : body.mesh.corners)
      for (int k = 0; k < 3; ++k) {
        if (periodic[k]) continue;
        box.lower[k] = std::min(box.lower[k], corner[k] - margin[k]);
        box.upper[k] = std::max(box.upper[k], corner[k] + margin[k]);
      }
  return box;
}

std::string script_text(const scene::Case& scene, const std::vector<WallBody>& bodies,
                        const Particles& particles) {
  const auto side = [](bool periodic) { return periodic ? 'p' : 'f'; };
  auto text = fmt::format(
      "# Written by repose for LIGGGHTS 3.8.\natom_style granular\natom_modify map array\n"
      "boundary {} {} {}\nnewton off\ncommunicate single vel yes\nunits si\n"
      "read_data particles.data\nneighbor {} bin\nneigh_modify delay 0\n",
      side(scene.periodic.x), side(scene.periodic.y), side(scene.periodic.z),
      shortest(kSkinRadii * particles.smallest_radius_m));
  text += materials_text(scene);
  text += fmt::format("pair_style gran {}\npair_coeff * *\ntimestep {}\n", model_of(scene),
                      shortest(particles.time_step_s));
  if (const Vec3& g = scene.gravity_m_s2; g.norm() > 0.0)
    text += fmt::format("fix weight all gravity {} vector {} {} {}\n", shortest(g.norm()),
                        shortest(g.x()), shortest(g.y()), shortest(g.z()));
  text += "fix motion all nve/sphere\n" + regions_text(scene);
  text +=
      "compute translation all ke\ncompute rotation all erotate/sphere\n"
      "compute touching all contact/atom\ncompute touches all reduce sum c_touching\n"
      "variable now equal step\nvariable energy equal c_translation+c_rotation\n"
      "variable contacts equal c_touches/2\n"
      "thermo_style custom step c_translation c_rotation c_touches\n"
      "thermo 1000000000\nthermo_modify lost error norm no\n";
  if (scene.output.snapshot_interval_s > 0.0)
    text += fmt::format(
        "dump frames all custom {} frames.dump {}\ndump_modify frames sort id "
        "format {}\n",
        steps_of(scene.output.snapshot_interval_s, particles.time_step_s), kColumns, kFormat);
  return text + Stages(scene, bodies, particles).text();
}

}  // namespace repose::dem_adapter::liggghts

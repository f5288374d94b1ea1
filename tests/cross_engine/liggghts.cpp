#include "liggghts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

#include "repose/base/error.hpp"

namespace repose::cross_engine {
namespace {

using scene::Vec3;

int type_of(const scene::Case& scene, const std::string& material) {
  return scene::material_index(scene, material) + 1;
}

void write_data(const scene::Case& scene, const std::filesystem::path& path) {
  std::ofstream out(path);
  out << fmt::format("particles\n\n{} atoms\n{} atom types\n\n", scene.particles.size(),
                     scene.materials.size());
  const char axes[] = {'x', 'y', 'z'};
  for (int k = 0; k < 3; ++k)
    out << fmt::format("{} {} {}lo {}hi\n", scene.lower_m[k], scene.upper_m[k], axes[k], axes[k]);
  out << "\nAtoms\n\n";
  for (std::size_t i = 0; i < scene.particles.size(); ++i) {
    const scene::Particle& p = scene.particles[i];
    const int type = type_of(scene, p.material);
    out << fmt::format("{} {} {:.17g} {} {:.17g} {:.17g} {:.17g}\n", i + 1, type, 2.0 * p.radius_m,
                       scene.materials[static_cast<std::size_t>(type - 1)].density_kg_m3,
                       p.position.x(), p.position.y(), p.position.z());
  }
}

/// A rectangle as triangles, cut into pieces of at most 0.1 m, which thin periodic boxes need.
void write_rectangle(const scene::Rectangle& r, std::ofstream& out) {
  const int n = std::max(1, static_cast<int>(std::ceil(r.edge_u.norm() / 0.1)));
  const int m = std::max(1, static_cast<int>(std::ceil(r.edge_v.norm() / 0.1)));
  const auto corner = [&](int i, int j) -> Vec3 {
    return r.origin + r.edge_u * (static_cast<double>(i) / n) +
           r.edge_v * (static_cast<double>(j) / m);
  };
  const auto triangle = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    out << "facet normal 0 0 0\nouter loop\n";
    for (const Vec3& x : {a, b, c})
      out << fmt::format("vertex {:.9g} {:.9g} {:.9g}\n", x.x(), x.y(), x.z());
    out << "endloop\nendfacet\n";
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      triangle(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1));
      triangle(corner(i, j), corner(i + 1, j + 1), corner(i, j + 1));
    }
}

/// A property of all pairs as LIGGGHTS wants it; pairs that the case lacks (wall on wall) get 0.5.
template <class Value>
std::string matrix(const scene::Case& scene, Value value) {
  std::string text = fmt::format("peratomtypepair {}", scene.materials.size());
  const int n = static_cast<int>(scene.materials.size());
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const int pair = scene::pair_index(scene, a, b);
      text +=
          fmt::format(" {}", pair < 0 ? 0.5 : value(scene.pairs[static_cast<std::size_t>(pair)]));
    }
  return text;
}

constexpr const char* kModel = "model hertz tangential history rolling_friction epsd";

std::string plane_wall(const scene::Case& scene, const scene::Wall& wall, const scene::Plane& p) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(p.normal[k]) == p.normal.norm())
      return fmt::format("fix {} all wall/gran {} primitive type {} {}plane {}\n", wall.name,
                         kModel, type_of(scene, wall.material), "xyz"[k], p.origin[k]);
  throw InputError("wall \"" + wall.name + "\": LIGGGHTS needs planes along the axes");
}

std::string input_text(const scene::Case& scene, const std::vector<std::string>& without,
                       const LiggghtsOptions& o, const std::filesystem::path& folder) {
  const auto boundary = [](bool periodic) { return periodic ? 'p' : 'f'; };
  std::string text = fmt::format(
      "atom_style granular\natom_modify map array\nboundary {} {} {}\nnewton off\n"
      "communicate single vel yes\nunits si\nread_data particles.data\nneighbor {} bin\n"
      "neigh_modify delay 0\nhard_particles yes\n",
      boundary(scene.periodic.x), boundary(scene.periodic.y), boundary(scene.periodic.z), o.skin_m);
  std::string young = "peratomtype", poisson = "peratomtype";
  for (const scene::Material& m : scene.materials) {
    young += fmt::format(" {}", m.youngs_modulus_pa);
    poisson += fmt::format(" {}", m.poissons_ratio);
  }
  const auto property = [&](const char* name, const std::string& values) {
    text += fmt::format("fix p_{} all property/global {} {}\n", name, name, values);
  };
  property("youngsModulus", young);
  property("poissonsRatio", poisson);
  property("coefficientRestitution", matrix(scene, [](const auto& p) { return p.restitution; }));
  property("coefficientFriction", matrix(scene, [](const auto& p) { return p.mu_s; }));
  property("coefficientRollingFriction", matrix(scene, [](const auto& p) { return p.mu_r; }));
  property("coefficientRollingViscousDamping",
           matrix(scene, [](const auto& p) { return p.rolling_damping; }));
  text +=
      fmt::format("pair_style gran {}\npair_coeff * *\ntimestep {:.17g}\n", kModel, o.time_step_s);
  const Vec3& g = scene.gravity_m_s2;
  text += fmt::format("fix g all gravity {} vector {} {} {}\n", g.norm(), g.x(), g.y(), g.z());
  std::ofstream mesh(folder / "walls.stl");
  mesh << "solid walls\n";
  int mesh_type = 0;
  for (const scene::Wall& wall : scene.walls) {
    if (std::find(without.begin(), without.end(), wall.name) != without.end()) continue;
    if (const auto* plane = std::get_if<scene::Plane>(&wall.shape)) {
      text += plane_wall(scene, wall, *plane);
    } else if (const auto* rectangle = std::get_if<scene::Rectangle>(&wall.shape)) {
      mesh_type = type_of(scene, wall.material);  // one for all
      write_rectangle(*rectangle, mesh);
    } else {
      throw InputError("wall \"" + wall.name + "\" is neither a plane nor a rectangle");
    }
  }
  mesh << "endsolid walls\n";
  if (mesh_type > 0)
    text += fmt::format(
        "fix mesh all mesh/surface file walls.stl type {}\n"
        "fix walls all wall/gran {} mesh n_meshes 1 meshes mesh\n",
        mesh_type, kModel);
  text += fmt::format(
      "fix i all nve/sphere\n"
      "dump d all custom {} frames.txt id x y z vx vy vz omegax omegay omegaz\n"
      "dump_modify d sort id format \"%d %.15g %.15g %.15g %.15g %.15g %.15g %.15g %.15g %.15g\"\n"
      "thermo {}\nthermo_modify lost error norm no\nrun {}\n",
      o.frame_interval, o.frame_interval, o.steps);
  return text;
}

std::vector<Frame> read_frames(const scene::Case& scene, double dt,
                               const std::filesystem::path& path) {
  std::ifstream in(path);
  std::vector<Frame> frames;
  std::string line;
  while (std::getline(in, line)) {
    if (line == "ITEM: TIMESTEP") {
      std::getline(in, line);
      frames.push_back({std::stod(line) * dt, scene.particles});
    } else if (line.starts_with("ITEM: ATOMS")) {
      for (std::size_t i = 0; i < scene.particles.size() && std::getline(in, line); ++i) {
        std::istringstream cells(line);
        std::size_t id = 0;
        cells >> id;
        scene::Particle& p = frames.back().particles.at(id - 1);
        for (Vec3* v : {&p.position, &p.velocity, &p.angular_velocity})
          for (int k = 0; k < 3; ++k) cells >> (*v)[k];
      }
    }
  }
  return frames;
}

}  // namespace

bool have_liggghts() {
  return std::system("command -v liggghts >/dev/null 2>&1 && command -v mpirun >/dev/null 2>&1") ==
         0;
}

std::vector<Frame> run_liggghts(const scene::Case& scene, const std::vector<std::string>& without,
                                const LiggghtsOptions& options,
                                const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  write_data(scene, folder / "particles.data");
  std::ofstream(folder / "in.case") << input_text(scene, without, options, folder);
  const std::string command =
      "cd '" + folder.string() +
      "' && mpirun --allow-run-as-root --oversubscribe --bind-to none -np 1 "
      "stdbuf -o0 liggghts -in in.case > out.log 2>&1";
  if (std::system(command.c_str()) != 0) {
    std::ifstream log(folder / "out.log");
    std::string all((std::istreambuf_iterator<char>(log)), {});
    throw SimulationError("LIGGGHTS failed: " +
                          all.substr(all.size() > 600 ? all.size() - 600 : 0));
  }
  return read_frames(scene, options.time_step_s, folder / "frames.txt");
}

}  // namespace repose::cross_engine

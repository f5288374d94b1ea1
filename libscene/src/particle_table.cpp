// Particles from a table on disk.
#include <cmath>
#include <map>

#include "repose/base/error.hpp"
#include "repose/base/file.hpp"
#include "repose/base/text.hpp"
#include "repose/scene/case.hpp"
#include "repose/table/io.hpp"

namespace repose::scene {
namespace {

/// Three columns as vectors; zeros if the table has none of them.
std::vector<Vec3> vectors(const table::Table& in, const std::string& prefix,
                          const std::string& suffix) {
  std::vector<Vec3> out(in.rows(), Vec3::Zero());
  if (!in.has(prefix + "x" + suffix)) return out;
  const char* const axes[3] = {"x", "y", "z"};
  for (int k = 0; k < 3; ++k) {
    const std::vector<double> values = in.numbers(prefix + axes[k] + suffix);
    for (std::size_t i = 0; i < out.size(); ++i) out[i][k] = values[i];
  }
  return out;
}

/// Names from a column of text, or of indices into the attribute `materials`.
std::vector<std::string> materials(const table::Table& in, const std::string& fallback,
                                   const std::string& name) {
  if (!in.has("material")) {
    if (fallback.empty())
      throw InputError(name + "has no column material; give material in [[particle_table]]");
    return std::vector<std::string>(in.rows(), fallback);
  }
  if (std::holds_alternative<std::vector<std::string>>(in.column("material").values))
    return in.texts("material");
  const auto found = in.attributes.find("materials");
  const auto* known = found == in.attributes.end()
                          ? nullptr
                          : std::get_if<std::vector<std::string>>(&found->second);
  if (known == nullptr)
    throw InputError(name +
                     "its column material holds numbers, but it has no attribute materials "
                     "with their names; give names");
  std::vector<std::string> out;
  for (std::int64_t m : in.integers("material")) {
    if (m < 0 || m >= static_cast<std::int64_t>(known->size()))
      throw InputError(name + "row " + std::to_string(out.size() + 1) + ": material = " +
                       std::to_string(m) + ": must be 0 to " + std::to_string(known->size() - 1));
    out.push_back((*known)[static_cast<std::size_t>(m)]);
  }
  return out;
}

/// A snapshot holds the spheres of clumps one by one; they would fall apart.
void refuse_spheres_of_clumps(const table::Table& in, const std::string& name) {
  if (!in.has("body")) return;
  std::map<std::int64_t, std::size_t> row_of;
  const std::vector<std::int64_t> bodies = in.integers("body");
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto [first, is_new] = row_of.emplace(bodies[i], i);
    if (!is_new)
      throw InputError(name + "rows " + std::to_string(first->second + 1) + " and " +
                       std::to_string(i + 1) +
                       " are spheres of one clump, body = " + std::to_string(bodies[i]) +
                       "; a table of particles has a row a clump: its centre, radius_m, clump and "
                       "qw, qx, qy, qz");
  }
}

}  // namespace

std::vector<Particle> load_particles(const Case& scene, const ParticleTable& given) {
  const table::Location location = table::parse_location(given.location);
  if (given.content_hash != 0 && content_hash(read_file(location.file)) != given.content_hash)
    throw InputError("particle table " + given.location +
                     ": the file has changed since the case was read; read the case again");
  const table::Table in = table::read_table(location);
  const std::string name = "particle table " + given.location + ": ";
  refuse_spheres_of_clumps(in, name);
  const std::vector<Vec3> position = vectors(in, "", "_m");
  const std::vector<Vec3> velocity = vectors(in, "v", "_m_s");
  const std::vector<Vec3> angular_velocity = vectors(in, "w", "_rad_s");
  const std::vector<double> radius = in.numbers("radius_m");
  const std::vector<std::string> material = materials(in, given.material, name);
  const std::vector<std::string> clump =
      in.has("clump") ? in.texts("clump") : std::vector<std::string>(in.rows(), given.clump);
  const std::vector<std::string> quaternion{"qw", "qx", "qy", "qz"};
  const Matrix turned = in.has("qw") ? in.matrix(quaternion) : Matrix();
  if (!in.has("x_m"))
    throw InputError(name + "has no columns x_m, y_m, z_m; they are the centres of the particles");
  std::vector<Particle> particles;
  for (std::size_t i = 0; i < in.rows(); ++i) {
    const std::string row = name + "row " + std::to_string(i + 1) + ": ";
    Particle particle;
    particle.material = material[i];
    particle.clump = clump[i];
    particle.position = position[i];
    particle.velocity = velocity[i];
    particle.angular_velocity = angular_velocity[i];
    particle.radius_m = radius[i];
    if (!(radius[i] > 0.0))
      throw InputError(row + "radius_m = " + shortest(radius[i]) + ": must be above 0");
    if (turned.size() > 0) {
      const Eigen::Index r = static_cast<Eigen::Index>(i);
      if (!(turned.row(r).norm() > 0.0))
        throw InputError(row + "qw, qx, qy, qz are all zero; give a quaternion");
      for (int k = 0; k < 4; ++k)
        particle.orientation_wxyz[static_cast<std::size_t>(k)] = turned(r, k);
    }
    material_index(scene, particle.material);
    if (!particle.clump.empty()) clump_shape(scene, particle.clump);
    for (int k = 0; k < 3; ++k)
      if (!(position[i][k] >= scene.lower_m[k] && position[i][k] < scene.upper_m[k]))
        throw InputError(row + std::string(1, "xyz"[k]) + "_m = " + shortest(position[i][k]) +
                         ": is outside the domain, " + shortest(scene.lower_m[k]) + " to " +
                         shortest(scene.upper_m[k]) + " m");
    particles.push_back(particle);
  }
  return particles;
}

}  // namespace repose::scene

#include <fmt/format.h>

#include "repose/base/error.hpp"
#include "repose/base/text.hpp"
#include "script.hpp"

namespace repose::dem_adapter::liggghts {
namespace {

constexpr double kLeastRestitution = 0.05;
constexpr std::size_t kMostMaterials = 30;  // groups of LIGGGHTS, less two

[[noreturn]] void refuse(const std::string& what, const std::string& remedy) {
  throw InputError(fmt::format("the engine liggghts cannot do {}; {}", what, remedy));
}

void check_contact(const scene::Case& scene) {
  if (scene.contact.tail == scene::Tail::clip)
    refuse("contact.tail = \"clip\"", "it keeps the attraction before separation: \"keep\"");
  const bool stiff = scene.contact.rolling == scene::RollingModel::c &&
                     scene.contact.rolling_stiffness == scene::RollingStiffness::kt;
  for (const auto& pair : scene.pairs) {
    const auto name = fmt::format("pair {} - {}", pair.first, pair.second);
    if (pair.restitution < kLeastRestitution)
      refuse(fmt::format("restitution = {} of {}", shortest(pair.restitution), name),
             fmt::format("it takes {} and more", kLeastRestitution));
    if (stiff && pair.rolling_damping != 0.0 && pair.mu_r > 0.0)
      refuse(fmt::format("rolling_damping = {} of {} with rolling_stiffness = \"kt\"",
                         shortest(pair.rolling_damping), name),
             "its model epsd2 has no damping: 0");
  }
}

void check_particles(const scene::Case& scene) {
  if (!scene.rains.empty())
    refuse(fmt::format("rain \"{}\"", scene.rains.front().name),
           "let particles be there from the start, by fill or particle_table");
  const auto no_clumps = [](const std::string& clump) {
    if (!clump.empty())
      refuse(fmt::format("clump \"{}\"", clump), "it simulates single spheres here");
  };
  if (scene.fill)
    for (const auto& layer : scene.fill->layers)
      for (const auto& grains : layer.mixture) no_clumps(grains.clump);
  for (const auto& particle : scene.particles) no_clumps(particle.clump);
  for (const auto& table : scene.particle_tables) no_clumps(table.clump);
}

void check_regions(const scene::Case& scene) {
  for (const auto& region : scene.regions) {
    if (region.removes)
      refuse(fmt::format("region \"{}\" with removes", region.name), "leave particles in");
    if (!region.cylinder) continue;
    const scene::Vec3 axis = region.cylinder->end - region.cylinder->start;
    if ((axis.array() != 0.0).count() != 1)
      refuse(fmt::format("the cylinder of region \"{}\"", region.name),
             "its axis must be parallel to x, y or z");
  }
}

}  // namespace

void require_possible(const scene::Case& scene) {
  check_contact(scene);
  check_particles(scene);
  check_regions(scene);
  if (scene.materials.size() > kMostMaterials)
    refuse(fmt::format("{} materials", scene.materials.size()),
           fmt::format("it has {} at most", kMostMaterials));
  for (const auto& stage : scene.stages)
    if (stage.coefficients)
      refuse(fmt::format("coefficients of stage \"{}\"", stage.name),
             "give the pairs their own throughout");
  if (scene.output.energy) refuse("output.energy = true", "it has no ledger of energy");
  if (scene.output.vtp && !scene.motions.empty())
    refuse("output.vtp = true with moving walls", "set it to false");
}

}  // namespace repose::dem_adapter::liggghts

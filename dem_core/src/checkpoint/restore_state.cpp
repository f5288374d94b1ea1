// A simulation from its tables and attributes.
#include <algorithm>
#include <string>

#include "checkpoint/columns.hpp"
#include "checkpoint/contact_records.hpp"
#include "repose/base/error.hpp"
#include "repose/dem/checkpoint.hpp"
#include "simulation_state.hpp"

namespace repose::dem {
namespace {

[[noreturn]] void inconsistent(const std::string& what) {
  throw StorageError("a checkpoint is inconsistent: " + what + "; begin the run anew");
}

/// Indices of spheres by id.
class SphereIndex {
 public:
  explicit SphereIndex(const Spheres& spheres) {
    for (std::size_t i = 0; i < spheres.size(); ++i)
      by_id_.emplace_back(spheres.id[i], static_cast<std::int32_t>(i));
    std::sort(by_id_.begin(), by_id_.end());
  }
  std::int32_t of(std::int32_t id) const {
    const auto found = std::lower_bound(by_id_.begin(), by_id_.end(),
                                        std::pair<std::int32_t, std::int32_t>{id, 0});
    if (found == by_id_.end() || found->first != id)
      inconsistent("there is no sphere " + std::to_string(id));
    return found->second;
  }

 private:
  std::vector<std::pair<std::int32_t, std::int32_t>> by_id_;
};

/// In the order of the table; those of clumps do not know their member yet.
Spheres spheres_of(const table::Table& table) {
  const auto id = short_integers(table, "id");
  const auto body = short_integers(table, "body");
  const auto material = short_integers(table, "material");
  const auto radius = table.numbers("radius");
  const auto mass = table.numbers("mass");
  const auto inverse_mass = table.numbers("inverse_mass");
  const auto inverse_inertia = table.numbers("inverse_inertia");
  const VectorColumn x(table, "position"), v(table, "velocity"), w(table, "angular_velocity");
  const VectorColumn force(table, "force"), torque(table, "torque");
  Spheres spheres;
  for (std::size_t r = 0; r < table.rows(); ++r) {
    spheres.add({.motion = {x[r], radius[r], v[r], inverse_mass[r]},
                 .spin = {w[r], inverse_inertia[r]},
                 .material = material[r],
                 .id = id[r],
                 .body = body[r],
                 .mass = mass[r]});
    spheres.load.back().force = force[r];
    spheres.load.back().torque = torque[r];
  }
  return spheres;
}

Clumps clumps_of(const table::Table& bodies, const table::Table& members, Spheres& spheres) {
  const SphereIndex index(spheres);
  const auto sphere = short_integers(members, "sphere");
  const VectorColumn local(members, "local"), arm(members, "arm");
  Clumps clumps;
  for (std::size_t m = 0; m < members.rows(); ++m) {
    clumps.members.push_back({index.of(sphere[m]), local[m], arm[m]});
    spheres.member[static_cast<std::size_t>(clumps.members[m].sphere)] =
        static_cast<std::int32_t>(m);
  }
  const auto body = short_integers(bodies, "body");
  const auto material = short_integers(bodies, "material");
  const auto count = short_integers(bodies, "spheres");
  const auto radius = bodies.numbers("radius");
  const auto mass = bodies.numbers("mass");
  const auto orientation_w = bodies.numbers("orientation_w");
  const VectorColumn x(bodies, "position"), v(bodies, "velocity"), l(bodies, "angular_momentum");
  const VectorColumn orientation(bodies, "orientation"), inertia(bodies, "inertia");
  const VectorColumn force(bodies, "force"), torque(bodies, "torque");
  std::int32_t first = 0;
  for (std::size_t c = 0; c < bodies.rows(); ++c) {
    const Vec3 q = orientation[c];
    clumps.all.push_back({.x = x[c],
                          .v = v[c],
                          .l = l[c],
                          .q = {orientation_w[c], q.x(), q.y(), q.z()},
                          .inertia = inertia[c],
                          .mass = mass[c],
                          .radius = radius[c],
                          .force = force[c],
                          .torque = torque[c],
                          .body = body[c],
                          .material = material[c],
                          .first = first,
                          .count = count[c]});
    first += count[c];
  }
  if (static_cast<std::size_t>(first) != members.rows()) inconsistent("spheres of clumps");
  return clumps;
}

/// order[k] is the row of the sphere that comes k-th in memory.
std::vector<std::int32_t> saved_order(const table::Table& spheres) {
  const auto place = spheres.integers("order");
  std::vector<std::int32_t> order(place.size(), -1);
  for (std::size_t r = 0; r < place.size(); ++r) {
    const auto k = static_cast<std::size_t>(place[r]);
    if (k >= order.size() || order[k] >= 0) inconsistent("order of spheres");
    order[k] = static_cast<std::int32_t>(r);
  }
  return order;
}

std::vector<ContactRecord> contacts_of(const table::Table& table) {
  const auto first = short_integers(table, "first");
  const auto second = short_integers(table, "second");
  const auto stored = table.numbers("stored");
  const VectorColumn slip(table, "slip"), rolling(table, "rolling");
  std::vector<ContactRecord> contacts;
  for (std::size_t r = 0; r < table.rows(); ++r)
    contacts.push_back({first[r], second[r], {slip[r], rolling[r]}, stored[r]});
  return contacts;
}

std::vector<WallContact> wall_contacts_of(const table::Table& table, const Spheres& spheres) {
  const SphereIndex index(spheres);
  const auto id = short_integers(table, "sphere");
  const auto wall = short_integers(table, "wall");
  const auto patch = short_integers(table, "patch");
  const auto overlap = table.numbers("overlap");
  const auto stored = table.numbers("stored");
  const VectorColumn normal(table, "normal"), slip(table, "slip"), rolling(table, "rolling");
  std::vector<WallContact> contacts;
  for (std::size_t r = 0; r < table.rows(); ++r) {
    contacts.push_back({normal[r],
                        overlap[r],
                        index.of(id[r]),
                        patch[r],
                        wall[r],
                        {{slip[r], rolling[r]}, stored[r]}});
  }
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const WallContact& a, const WallContact& b) { return a.sphere < b.sphere; });
  return contacts;
}

/// Those of at least one sphere that is simulated here.
std::vector<ContactRecord> of_spheres_here(std::vector<ContactRecord> contacts,
                                           const Spheres& spheres) {
  std::vector<std::int32_t> here;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    if (!spheres.is_ghost(i)) here.push_back(spheres.id[i]);
  std::sort(here.begin(), here.end());
  const auto is_here = [&](std::int32_t id) {
    return std::binary_search(here.begin(), here.end(), id);
  };
  std::erase_if(contacts, [&](const ContactRecord& contact) {
    return !is_here(contact.first) && !is_here(contact.second);
  });
  return contacts;
}

}  // namespace

void Simulation::State::restore(const Checkpoint& saved) {
  prepare_insertion();
  steps = saved.integer("steps");
  dt = saved.number("time_step_s");
  next_sphere = static_cast<std::int32_t>(saved.integer("next_sphere"));
  next_body = static_cast<std::int32_t>(saved.integer("next_body"));
  ledger.inserted = saved.integer("inserted");
  ledger.removed = saved.integer("removed");
  ledger.inserted_kg = saved.number("inserted_kg");
  ledger.removed_kg = saved.number("removed_kg");
  const table::Table& rains_then = saved.table("/rains");
  if (rains_then.rows() != rains.size()) inconsistent("number of rains");
  const auto placed = rains_then.integers("placed");
  const auto attempts = rains_then.integers("attempts");
  const auto placed_kg = rains_then.numbers("placed_mass");
  for (std::size_t r = 0; r < rains.size(); ++r)
    rains[r].go_on_from({placed[r], attempts[r], placed_kg[r]});
  restore_bodies_and_lists(saved);
  restore_sums(saved);
}

/// What is summed is summed in the saved order; when lists were built changes nothing.
void Simulation::State::restore_bodies_and_lists(const Checkpoint& saved) {
  const table::Table& table = saved.table("/spheres");
  const std::vector<std::int32_t> order = saved_order(table);
  spheres = spheres_of(table);
  clumps = clumps_of(saved.table("/clumps"), saved.table("/clump_spheres"), spheres);
  for (std::size_t k = 0; k < order.size(); ++k)
    spheres.key[static_cast<std::size_t>(order[k])] = k;
  spheres.select(order);
  follow_order(spheres, clumps);
  spheres_present = static_cast<std::int64_t>(spheres.size());
  wall_contacts.all = wall_contacts_of(saved.table("/wall_contacts"), spheres);
  restore_stages(saved);
  least_radius = saved.number("least_radius_m");
  skin = Skin(least_radius, options.skin_radii);
  if (!domain.is_alone()) domain.share_out(box, population());
  rebuild_lists(Order::kept);
  begin_contacts(of_spheres_here(contacts_of(saved.table("/contacts")), spheres), spheres,
                 lists.pairs, pool);
}

/// Walls go through the stages again; the laws are those of the stage under way.
void Simulation::State::restore_stages(const Checkpoint& saved) {
  const table::Table& stages = saved.table("/stages");
  const auto& names = stages.texts("name");
  const auto starts = stages.numbers("start");
  for (std::size_t s = 0; s < names.size(); ++s) stage_start_s[names[s]] = starts[s];
  for (const auto& [name, start] : stage_start_s)
    if (start < time_s()) walls.begin_stage(name, start);
  if (steps > 0) walls.advance(time_s(), dt);
  for (const auto& [name, start] : stage_start_s)
    if (start >= time_s()) walls.begin_stage(name, start);
  const scene::Stage* under_way = nullptr;
  for (const scene::Stage& stage : scene.stages)
    if (stage_start_s.contains(stage.name) &&
        (under_way == nullptr || stage_start_s[stage.name] >= stage_start_s[under_way->name]))
      under_way = &stage;
  if (under_way != nullptr) laws = LawTable(scene, under_way);

  const table::Table& then = saved.table("/walls");
  if (then.rows() != walls.size()) inconsistent("number of walls");
  const auto present = then.integers("present");
  for (std::size_t w = 0; w < walls.size(); ++w)
    if (present[w] == 0) walls.open(w);
}

void Simulation::State::restore_sums(const Checkpoint& saved) {
  rebuilds = saved.integer("rebuilds");
  wall_load_steps = saved.integer("wall_load_steps");
  initial_j = saved.number("initial_j");
  counted.inserted_j = saved.number("inserted_j");
  counted.removed_j = saved.number("removed_j");
  const table::Table& sums = saved.table("/sums");
  const auto& names = sums.texts("name");
  const auto high = sums.integers("high");
  const auto low = sums.integers("low");
  std::size_t found = 0;
  for (const auto& [name, sum] : exact_sums())
    for (std::size_t r = 0; r < names.size(); ++r)
      if (names[r] == name) {
        ++found;
        if (domain.communicator().is_root())
          *sum = ExactSum(ExactSum::Parts{high[r], static_cast<std::uint64_t>(low[r])});
      }
  if (found != names.size() || found != exact_sums().size()) inconsistent("sums");
  largest_speed = saved.number("largest_speed_m_s");
  const auto overlap = saved.numbers("largest_overlap_m", 2);
  largest_overlap = {.overlap_m = overlap[0],
                     .smaller_radius_m = overlap[1],
                     .sphere = static_cast<std::int32_t>(saved.integer("largest_overlap_sphere")),
                     .other = static_cast<std::int32_t>(saved.integer("largest_overlap_other")),
                     .is_at_wall = saved.integer("largest_overlap_at_wall") != 0};
}

}  // namespace repose::dem

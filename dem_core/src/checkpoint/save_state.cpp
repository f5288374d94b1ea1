// The state of a simulation as tables and attributes.
#include <algorithm>
#include <numeric>

#include "checkpoint/build_name.hpp"
#include "checkpoint/columns.hpp"
#include "checkpoint/contact_records.hpp"
#include "repose/dem/checkpoint.hpp"
#include "simulation_state.hpp"

namespace repose::dem {
namespace {

/// Indices of records in the order of their keys; equal ones stay as they are.
template <class KeyOf>
std::vector<std::size_t> sorted_by(std::size_t count, KeyOf key_of) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return key_of(a) < key_of(b); });
  return order;
}

table::Table spheres_table(const Spheres& spheres) {
  const auto order = sorted_by(spheres.size(), [&](std::size_t i) { return spheres.id[i]; });
  TableBuilder rows(order.size());
  rows.integers("id", [&](std::size_t r) { return spheres.id[order[r]]; });
  rows.integers("body", [&](std::size_t r) { return spheres.body[order[r]]; });
  rows.integers("material", [&](std::size_t r) { return spheres.material[order[r]]; });
  rows.integers("order", [&](std::size_t r) { return static_cast<std::int64_t>(order[r]); });
  rows.numbers("radius", "m", [&](std::size_t r) { return spheres.motion[order[r]].radius; });
  rows.numbers("mass", "kg", [&](std::size_t r) { return spheres.mass[order[r]]; });
  rows.numbers("inverse_mass", "1/kg",
               [&](std::size_t r) { return spheres.motion[order[r]].inv_mass; });
  rows.numbers("inverse_inertia", "1/(kg m^2)",
               [&](std::size_t r) { return spheres.spin[order[r]].inv_inertia; });
  rows.vectors("position", "m", [&](std::size_t r) { return spheres.motion[order[r]].x; });
  rows.vectors("velocity", "m/s", [&](std::size_t r) { return spheres.motion[order[r]].v; });
  rows.vectors("angular_velocity", "rad/s",
               [&](std::size_t r) { return spheres.spin[order[r]].w; });
  rows.vectors("force", "N", [&](std::size_t r) { return spheres.load[order[r]].force; });
  rows.vectors("torque", "N m", [&](std::size_t r) { return spheres.load[order[r]].torque; });
  return rows.take();
}

table::Table clumps_table(const Clumps& clumps) {
  const auto order = sorted_by(clumps.size(), [&](std::size_t c) { return clumps.all[c].body; });
  const auto of = [&](std::size_t r) -> const Clump& { return clumps.all[order[r]]; };
  TableBuilder rows(order.size());
  rows.integers("body", [&](std::size_t r) { return of(r).body; });
  rows.integers("material", [&](std::size_t r) { return of(r).material; });
  rows.integers("spheres", [&](std::size_t r) { return of(r).count; });
  rows.numbers("radius", "m", [&](std::size_t r) { return of(r).radius; });
  rows.numbers("mass", "kg", [&](std::size_t r) { return of(r).mass; });
  rows.vectors("inertia", "kg m^2", [&](std::size_t r) { return of(r).inertia; });
  rows.vectors("position", "m", [&](std::size_t r) { return of(r).x; });
  rows.vectors("velocity", "m/s", [&](std::size_t r) { return of(r).v; });
  rows.vectors("angular_momentum", "kg m^2/s", [&](std::size_t r) { return of(r).l; });
  rows.numbers("orientation_w", "1", [&](std::size_t r) { return of(r).q.w; });
  rows.vectors("orientation", "1",
               [&](std::size_t r) { return Vec3(of(r).q.x, of(r).q.y, of(r).q.z); });
  rows.vectors("force", "N", [&](std::size_t r) { return of(r).force; });
  rows.vectors("torque", "N m", [&](std::size_t r) { return of(r).torque; });
  return rows.take();
}

/// The spheres of clumps, clump after clump as in /clumps, each from its first sphere on.
table::Table clump_spheres_table(const Clumps& clumps, const Spheres& spheres) {
  const auto order = sorted_by(clumps.size(), [&](std::size_t c) { return clumps.all[c].body; });
  std::vector<const Member*> members;
  for (const std::size_t c : order)
    for (std::int32_t m = 0; m < clumps.all[c].count; ++m)
      members.push_back(&clumps.members[static_cast<std::size_t>(clumps.all[c].first + m)]);
  TableBuilder rows(members.size());
  rows.integers("sphere", [&](std::size_t r) {
    return spheres.id[static_cast<std::size_t>(members[r]->sphere)];
  });
  rows.vectors("local", "m", [&](std::size_t r) { return members[r]->local; });
  rows.vectors("arm", "m", [&](std::size_t r) { return members[r]->arm; });
  return rows.take();
}

table::Table contacts_table(const std::vector<ContactRecord>& contacts) {
  TableBuilder rows(contacts.size());
  rows.integers("first", [&](std::size_t r) { return contacts[r].first; });
  rows.integers("second", [&](std::size_t r) { return contacts[r].second; });
  rows.vectors("slip", "m", [&](std::size_t r) { return contacts[r].history.slip; });
  rows.vectors("rolling", "N m", [&](std::size_t r) { return contacts[r].history.rolling; });
  rows.numbers("stored", "J", [&](std::size_t r) { return contacts[r].stored_j; });
  return rows.take();
}

table::Table wall_contacts_table(const WallContacts& contacts, const Spheres& spheres) {
  const auto id_of = [&](std::size_t c) {
    return spheres.id[static_cast<std::size_t>(contacts.all[c].sphere)];
  };
  const auto order = sorted_by(contacts.all.size(), id_of);
  const auto of = [&](std::size_t r) -> const WallContact& { return contacts.all[order[r]]; };
  TableBuilder rows(order.size());
  rows.integers("sphere", [&](std::size_t r) { return id_of(order[r]); });
  rows.integers("wall", [&](std::size_t r) { return of(r).wall; });
  rows.integers("patch", [&](std::size_t r) { return of(r).patch; });
  rows.vectors("normal", "1", [&](std::size_t r) { return of(r).normal; });
  rows.numbers("overlap", "m", [&](std::size_t r) { return of(r).overlap; });
  rows.vectors("slip", "m", [&](std::size_t r) { return of(r).contact.history.slip; });
  rows.vectors("rolling", "N m", [&](std::size_t r) { return of(r).contact.history.rolling; });
  rows.numbers("stored", "J", [&](std::size_t r) { return of(r).contact.stored_j; });
  return rows.take();
}

/// Where walls are follows from the time.
table::Table walls_table(const Walls& walls) {
  TableBuilder rows(walls.size());
  rows.integers("present", [&](std::size_t w) { return walls.at(w).present ? 1 : 0; });
  return rows.take();
}

/// Sums to the last bit: integers of 128 bits in units of 2^-80, in two halves.
table::Table sums_table(const std::map<std::string, ExactSum>& totals) {
  const std::vector<std::pair<std::string, ExactSum>> sums(totals.begin(), totals.end());
  TableBuilder rows(sums.size());
  rows.texts("name", [&](std::size_t r) { return sums[r].first; });
  rows.integers("high", [&](std::size_t r) { return sums[r].second.parts().high; });
  rows.integers(
      "low", [&](std::size_t r) { return static_cast<std::int64_t>(sums[r].second.parts().low); });
  return rows.take();
}

table::Table stages_table(const std::map<std::string, double>& stage_start_s) {
  const std::vector<std::pair<std::string, double>> begun(stage_start_s.begin(),
                                                          stage_start_s.end());
  TableBuilder rows(begun.size());
  rows.texts("name", [&](std::size_t r) { return begun[r].first; });
  rows.numbers("start", "s", [&](std::size_t r) { return begun[r].second; });
  return rows.take();
}

table::Table rains_table(const std::vector<RainSource>& rains) {
  TableBuilder rows(rains.size());
  rows.integers("placed", [&](std::size_t r) { return rains[r].progress().placed; });
  rows.integers("attempts", [&](std::size_t r) { return rains[r].progress().attempts; });
  rows.numbers("placed_mass", "kg", [&](std::size_t r) { return rains[r].progress().placed_kg; });
  return rows.take();
}

}  // namespace

Checkpoint Simulation::State::checkpoint() {
  Checkpoint saved;
  saved.case_text = scene::case_text(scene);
  const LargestOverlap deepest = largest_overlap_of_all();
  const bool is_alone = domain.is_alone();
  const Whole whole = is_alone ? Whole{} : gathered();
  const Spheres& all = is_alone ? spheres : whole.spheres;
  const Clumps& bodies = is_alone ? clumps : whole.clumps;
  saved.tables = {
      {"/spheres", spheres_table(all)},
      {"/clumps", clumps_table(bodies)},
      {"/clump_spheres", clump_spheres_table(bodies, all)},
      {"/contacts",
       contacts_table(is_alone ? contact_records(spheres, lists.pairs, pool) : whole.contacts)},
      {"/wall_contacts", wall_contacts_table(is_alone ? wall_contacts : whole.wall_contacts, all)},
      {"/walls", walls_table(walls)},
      {"/sums", sums_table(totals())},
      {"/stages", stages_table(stage_start_s)},
      {"/rains", rains_table(rains)},
  };
  saved.attributes = {
      {"build", build_name()},
      {"steps", steps},
      {"time_step_s", dt},
      {"time_step_option_s", options.time_step_s},
      {"skin_radii", options.skin_radii},
      {"least_radius_m", least_radius},
      {"rebuilds", rebuilds},
      {"next_sphere", static_cast<std::int64_t>(next_sphere)},
      {"next_body", static_cast<std::int64_t>(next_body)},
      {"inserted", ledger.inserted},
      {"removed", ledger.removed},
      {"inserted_kg", ledger.inserted_kg},
      {"removed_kg", ledger.removed_kg},
      {"wall_load_steps", wall_load_steps},
      {"initial_j", initial_j},
      {"inserted_j", counted.inserted_j},
      {"removed_j", counted.removed_j},
      {"largest_speed_m_s", largest_speed},
      {"largest_overlap_m", std::vector<double>{deepest.overlap_m, deepest.smaller_radius_m}},
      {"largest_overlap_sphere", static_cast<std::int64_t>(deepest.sphere)},
      {"largest_overlap_other", static_cast<std::int64_t>(deepest.other)},
      {"largest_overlap_at_wall", std::int64_t{deepest.is_at_wall ? 1 : 0}},
  };
  return saved;
}

}  // namespace repose::dem

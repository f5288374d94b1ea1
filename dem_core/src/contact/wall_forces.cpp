#include <algorithm>
#include <array>

#include "contact/contact_evaluation.hpp"
#include "contact/contact_forces.hpp"
#include "repose/base/error.hpp"

namespace repose::dem {
namespace {

constexpr double kSamePoint = 1e-9;  // of the radius

/// One wall that a sphere touches.
struct WallTouch {
  ClosestPoint point;
  std::int32_t entry;  // in the wall list
  std::int32_t wall;
};

/// The walls that touch one sphere.
struct Touches {
  std::array<WallTouch, 32> items;
  std::size_t count = 0;
  void add(const WallTouch& touch) {
    REPOSE_ASSERT(count < items.size(), "one sphere touches more than 32 walls");
    items[count++] = touch;
  }
};

/// Faces before rims, then by depth, then by wall: the order in which contacts are accepted.
bool accepted_before(const WallTouch& a, const WallTouch& b) {
  if (a.point.feature != b.point.feature) return a.point.feature == Feature::face;
  if (a.point.distance != b.point.distance) return a.point.distance < b.point.distance;
  return a.wall < b.wall;
}

/// Whether an accepted contact already does what `touch` would do: it meets the same point, or the
/// rim of `touch` lies on its wall, as between neighbors in one plane or at a corner of a box.
bool is_covered(const WallTouch& touch, const WallTouch& accepted, const Vec3& x, double radius,
                const std::vector<WallSurface>& walls) {
  const double tolerance = kSamePoint * radius;
  if ((touch.point.offset - accepted.point.offset).squaredNorm() < tolerance * tolerance)
    return true;
  if (touch.point.feature == Feature::face) return false;
  const Vec3 on_rim = x + touch.point.offset;
  const WallSurface& wall = walls[static_cast<std::size_t>(accepted.wall)];
  return std::abs(closest_point(wall, on_rim).distance) < tolerance;
}

/// Leaves each contact point once.
void keep_distinct(const Vec3& x, double radius, const std::vector<WallSurface>& walls,
                   Touches& touches) {
  const auto begin = touches.items.begin();
  std::sort(begin, begin + static_cast<std::ptrdiff_t>(touches.count), accepted_before);
  std::size_t kept = 0;
  for (std::size_t t = 0; t < touches.count; ++t) {
    const WallTouch touch = touches.items[t];
    bool covered = false;
    for (std::size_t k = 0; k < kept && !covered; ++k)
      covered = is_covered(touch, touches.items[k], x, radius, walls);
    if (!covered) touches.items[kept++] = touch;
  }
  touches.count = kept;
}

/// The row of one sphere in the wall list.
struct Row {
  std::int32_t first, last;
};

/// The contact slot of an accepted touch: its own, else that of a wall of the same patch which the
/// sphere has just left, so that rolling over a seam keeps the history; else a new one.
std::int32_t contact_of(const WallTouch& touch, const Touches& touches, Row row,
                        const std::vector<WallSurface>& walls, const Motion& sphere,
                        NeighborList& list, ContactPool& pool) {
  Neighbor& own = list.entries[static_cast<std::size_t>(touch.entry)];
  if (own.contact != kNoContact) return own.contact;
  const int patch = walls[static_cast<std::size_t>(touch.wall)].patch;
  for (std::int32_t e = row.first; e < row.last; ++e) {
    Neighbor& other = list.entries[static_cast<std::size_t>(e)];
    if (other.contact == kNoContact || walls[static_cast<std::size_t>(other.other)].patch != patch)
      continue;
    bool in_use = false;
    for (std::size_t t = 0; t < touches.count; ++t) in_use = in_use || touches.items[t].entry == e;
    if (in_use) continue;
    own.contact = other.contact;
    other.contact = kNoContact;
    return own.contact;
  }
  own.contact = pool.begin_contact(sphere_wall(sphere.radius, 1.0 / sphere.inv_mass));
  return own.contact;
}

void end_separated(const Touches& touches, Row row, NeighborList& list, ContactPool& pool) {
  for (std::int32_t e = row.first; e < row.last; ++e) {
    Neighbor& neighbor = list.entries[static_cast<std::size_t>(e)];
    if (neighbor.contact == kNoContact) continue;
    bool touching = false;
    for (std::size_t t = 0; t < touches.count; ++t)
      touching = touching || touches.items[t].entry == e;
    if (touching) continue;
    pool.end_contact(neighbor.contact);
    neighbor.contact = kNoContact;
  }
}

}  // namespace

std::size_t add_wall_forces(const LawTable& laws, const std::vector<WallSurface>& walls, double dt,
                            Spheres& spheres, NeighborList& list, ContactPool& pool,
                            DeepestOverlap& deepest, ContactEnergies* energies) {
  std::size_t contacts = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Row row{list.first[i], list.first[i + 1]};
    if (row.first == row.last) continue;
    const Motion& sphere = spheres.motion[i];
    Touches touches;
    for (std::int32_t e = row.first; e < row.last; ++e) {
      const std::int32_t w = list.entries[static_cast<std::size_t>(e)].other;
      const WallSurface& wall = walls[static_cast<std::size_t>(w)];
      if (!wall.present) continue;
      const ClosestPoint point = closest_point(wall, sphere.x);
      if (point.distance < sphere.radius) touches.add({point, e, w});
    }
    if (touches.count > 1) keep_distinct(sphere.x, sphere.radius, walls, touches);
    Load& load = spheres.load[i];
    for (std::size_t t = 0; t < touches.count; ++t) {
      const WallTouch& touch = touches.items[t];
      const WallSurface& wall = walls[static_cast<std::size_t>(touch.wall)];
      const ContactKinematics now =
          wall_kinematics(direction_to(wall, touch.point), sphere.radius - touch.point.distance,
                          sphere, spheres.spin[i].w, Vec3::Zero());
      deepest.see(now.overlap, sphere.radius, static_cast<std::int32_t>(i), touch.wall, true);
      const double arm = sphere.radius - 0.5 * now.overlap;
      Contact& contact = pool.at(contact_of(touch, touches, row, walls, sphere, list, pool));
      const PairLaw& law = laws.at(spheres.material[i], wall.material);
      NoEnergies none;
      const ContactForce f = energies != nullptr
                                 ? contact_force(laws.model(), law, now, dt, contact, *energies)
                                 : contact_force(laws.model(), law, now, dt, contact, none);
      load.force += f.force;
      load.torque += arm * cross(now.normal, f.tangential) + f.rolling_torque;
    }
    contacts += touches.count;
    end_separated(touches, row, list, pool);
  }
  return contacts;
}

}  // namespace repose::dem

#include "parallel/domain.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace repose::dem {
namespace {

constexpr std::int32_t kGone = -1;

/// What a body costs in a step, about, in nanoseconds (profile of bench/bed.sh); only ratios
/// matter.
struct Costs {
  std::int64_t sphere = 10, pair = 7, contact = 23, facet = 100;
};

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// Of each sphere, what it takes in a step; half of a pair's cost goes to each of the two.
std::vector<std::int64_t> costs_of(const Population& here) {
  const Costs costs;
  std::vector<std::int64_t> twice(here.spheres.size(), 2 * costs.sphere);
  for (const Neighbor& neighbor : here.lists.pairs.entries) {
    const std::int64_t cost = costs.pair + (neighbor.contact != kNoContact ? costs.contact : 0);
    twice[index(neighbor.row)] += cost;
    twice[index(neighbor.other)] += cost;
  }
  // Spheres added since the lists were built come last and have no rows.
  for (std::size_t i = 0; i + 1 < here.lists.walls.first.size(); ++i)
    twice[i] += 2 * costs.facet * static_cast<std::int64_t>(here.lists.walls.row(i).size());
  return twice;
}

PairContactRecord packed_contact(const Neighbor& neighbor, const Population& here) {
  return record_of(contact_record(neighbor, here.spheres, here.pool));
}

ArrivedContact arrived_contact(const ContactRecord& record, std::int32_t first,
                               std::int32_t second) {
  const ContactHistory& seen = record.history;
  if (first < second) return {first, second, {seen, record.stored_j}};
  return {second, first, {seen_from_the_other(seen), record.stored_j}};
}

/// Spheres of one size, up to a factor of two, and where a rank has them.
struct Extent {
  double lower[3], upper[3];
  double largest_radius;
};

/// Where a rank has spheres, level by level of size; positions are the images closest to `middle`.
std::vector<Extent> extents_of(const Box& box, const Vec3& middle, const Spheres& spheres) {
  double largest = 0.0;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    largest = std::max(largest, spheres.motion[i].radius);
  std::vector<Extent> levels;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Motion& sphere = spheres.motion[i];
    const auto level = static_cast<std::size_t>(std::max(0, std::ilogb(largest / sphere.radius)));
    while (level >= levels.size())
      levels.push_back({{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}, 0.0});
    Extent& extent = levels[level];
    const Vec3 x = middle + box.nearest_image(sphere.x - middle);
    for (int k = 0; k < 3; ++k) {
      extent.lower[k] = std::min(extent.lower[k], x[k]);
      extent.upper[k] = std::max(extent.upper[k], x[k]);
    }
    extent.largest_radius = std::max(extent.largest_radius, sphere.radius);
  }
  std::erase_if(levels, [](const Extent& extent) { return extent.largest_radius == 0.0; });
  return levels;
}

/// How far the closest images of two intervals of a coordinate are apart.
double gap(const Box& box, int k, double a_lower, double a_upper, double b_lower, double b_upper) {
  const auto apart = [&](double shift) {
    return std::max({b_lower - (a_upper + shift), a_lower + shift - b_upper, 0.0});
  };
  if (!box.periodic[k]) return apart(0.0);
  return std::min({apart(0.0), apart(box.length[k]), apart(-box.length[k])});
}

/// Whether spheres of two extents may come closer than the skin.
bool may_touch(const Box& box, double skin, const Extent& a, const Extent& b) {
  double distance2 = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double least = gap(box, k, a.lower[k], a.upper[k], b.lower[k], b.upper[k]);
    distance2 += least * least;
  }
  // A little more than the search's reach, whose sums are rounded in another way.
  const double reach = (a.largest_radius + b.largest_radius + skin) * (1.0 + 1e-9);
  return distance2 < reach * reach;
}

/// Whether any image of a sphere comes closer than the skin to one that lies in `extent`.
bool may_touch(const Box& box, double skin, const Motion& sphere, const Extent& extent) {
  const Vec3& x = sphere.x;
  return may_touch(box, skin, {{x.x(), x.y(), x.z()}, {x.x(), x.y(), x.z()}, sphere.radius},
                   extent);
}

}  // namespace

std::vector<WeightedPoint> weighted_bodies(const Population& here) {
  const std::vector<std::int64_t> cost = costs_of(here);
  std::vector<WeightedPoint> points;
  for (std::size_t i = 0; i < here.spheres.size(); ++i)
    if (here.spheres.is_alone(i)) points.push_back({here.spheres.motion[i].x, cost[i]});
  for (const Clump& clump : here.clumps.all) {
    std::int64_t sum = 0;
    for (std::int32_t m = clump.first; m < clump.first + clump.count; ++m)
      sum += cost[index(here.clumps.members[index(m)].sphere)];
    points.push_back({clump.x, sum});
  }
  return points;
}

void begin_contacts(const std::vector<ArrivedContact>& arrived, NeighborList& pairs,
                    ContactPool& pool) {
  for (const ArrivedContact& one : arrived) {
    Neighbor& neighbor = entry(pairs, one.i, one.j);
    if (neighbor.contact == kNoContact) neighbor.contact = pool.append(one.contact);
  }
}

void Halo::update(const Communicator& communicator, Spheres& spheres) {
  std::vector<Communicator::Transfer> transfers;
  for (Peer& peer : peers) {
    double* to = peer.out_numbers.data();
    for (const std::int32_t i : peer.out) {
      const Vec3 &x = spheres.motion[index(i)].x, &v = spheres.motion[index(i)].v,
                 &w = spheres.spin[index(i)].w;
      for (const Vec3* const part : {&x, &v, &w})
        for (int k = 0; k < 3; ++k) *to++ = (*part)[k];
    }
    transfers.push_back({peer.rank, peer.out_numbers, peer.in_numbers});
  }
  communicator.transfer(transfers);
  for (const Peer& peer : peers) {
    const double* from = peer.in_numbers.data();
    for (const std::int32_t i : peer.in) {
      spheres.motion[index(i)].x = {from[0], from[1], from[2]};
      spheres.motion[index(i)].v = {from[3], from[4], from[5]};
      spheres.spin[index(i)].w = {from[6], from[7], from[8]};
      spheres.load[index(i)] = {};
      from += 9;
    }
  }
}

void Halo::follow_order(const std::vector<std::int32_t>& new_index) {
  const auto follow = [&](std::vector<std::int32_t>& spheres, std::vector<double>& numbers) {
    for (std::int32_t& i : spheres) i = new_index[index(i)];
    std::erase(spheres, kGone);
    numbers.resize(9 * spheres.size());
  };
  for (Peer& peer : peers) {
    follow(peer.out, peer.out_numbers);
    follow(peer.in, peer.in_numbers);
  }
}

Parcel Domain::parcel_of(const Population& here) {
  Parcel parcel;
  for (std::size_t i = 0; i < here.spheres.size(); ++i)
    if (here.spheres.is_alone(i)) parcel.spheres.push_back(record_of(here.spheres, i));
  for (const Clump& clump : here.clumps.all) add_clump(clump, here.clumps, here.spheres, parcel);
  for (const Neighbor& neighbor : here.lists.pairs.entries)
    if (neighbor.contact != kNoContact && !here.spheres.is_ghost(index(neighbor.row)))
      parcel.contacts.push_back(packed_contact(neighbor, here));
  for (const WallContact& contact : here.wall_contacts.all)
    parcel.wall_contacts.push_back(record_of(contact, here.spheres.id[index(contact.sphere)]));
  return parcel;
}

/// The rank that each sphere known here belongs to now; of ghosts, -1.
std::vector<int> Domain::owners(const Population& here) const {
  std::vector<int> owner(here.spheres.size(), -1);
  for (std::size_t i = 0; i < here.spheres.size(); ++i)
    if (here.spheres.is_alone(i)) owner[i] = decomposition_.owner_of(here.spheres.motion[i].x);
  for (const Clump& clump : here.clumps.all) {
    const int rank = decomposition_.owner_of(clump.x);
    for (std::int32_t m = clump.first; m < clump.first + clump.count; ++m)
      owner[index(here.clumps.members[index(m)].sphere)] = rank;
  }
  return owner;
}

/// Drops all spheres but those of this rank, with their clumps and contacts with walls, which go on
/// elsewhere. Returns the new index of each, -1 if it is gone.
std::vector<std::int32_t> Domain::keep_own(const std::vector<int>& owner, Population here) const {
  std::vector<std::int32_t> kept, new_index(owner.size(), kGone);
  for (std::size_t i = 0; i < owner.size(); ++i) {
    if (owner[i] != communicator_.rank()) continue;
    new_index[i] = static_cast<std::int32_t>(kept.size());
    kept.push_back(static_cast<std::int32_t>(i));
  }
  std::erase_if(here.wall_contacts.all, [&](const WallContact& contact) {
    return new_index[index(contact.sphere)] == kGone;
  });
  here.wall_contacts.follow_order(new_index);
  here.spheres.select(kept);
  remove_clumps(new_index, here.spheres, here.clumps);
  return new_index;
}

void Domain::share_out(const Box& box, Population here) {
  decomposition_ = Decomposition(
      box, communicator_.is_root() ? weighted_bodies(here) : std::vector<WeightedPoint>{},
      communicator_.size(), communicator_);
  ++cuts_;
  keep_own(owners(here), here);
}

void Domain::balance(const Box& box, const Population& here, double worst) {
  const std::vector<WeightedPoint> bodies = weighted_bodies(here);
  std::int64_t cost = 0;
  for (const WeightedPoint& body : bodies) cost += body.cost;
  if (imbalance(cost, communicator_) <= worst) return;
  decomposition_ = Decomposition(box, bodies, communicator_.size(), communicator_);
  ++cuts_;
}

/// Sends bodies that belong to other ranks there and drops them here, and all ghosts. Returns the
/// new index of each sphere, -1 if it left.
std::vector<std::int32_t> Domain::send_away(const std::vector<int>& owner, Population here,
                                            std::vector<Parcel>& arrived) const {
  const int me = communicator_.rank();
  std::vector<Parcel> leaving(static_cast<std::size_t>(communicator_.size()));
  const auto leaves = [&](std::int32_t i) { return owner[index(i)] >= 0 && owner[index(i)] != me; };
  const auto parcel_for = [&](std::int32_t i) -> Parcel& {
    return leaving[static_cast<std::size_t>(owner[index(i)])];
  };
  for (std::size_t i = 0; i < here.spheres.size(); ++i)
    if (here.spheres.is_alone(i) && leaves(static_cast<std::int32_t>(i)))
      parcel_for(static_cast<std::int32_t>(i)).spheres.push_back(record_of(here.spheres, i));
  for (const Clump& clump : here.clumps.all) {
    const std::int32_t sphere = here.clumps.members[index(clump.first)].sphere;
    if (leaves(sphere)) add_clump(clump, here.clumps, here.spheres, parcel_for(sphere));
  }
  for (const Neighbor& neighbor : here.lists.pairs.entries) {
    if (neighbor.contact == kNoContact) continue;
    const int of_row = owner[index(neighbor.row)];
    const int of_other = owner[index(neighbor.other)];
    if (leaves(neighbor.row))
      parcel_for(neighbor.row).contacts.push_back(packed_contact(neighbor, here));
    if (leaves(neighbor.other) && of_other != of_row)
      parcel_for(neighbor.other).contacts.push_back(packed_contact(neighbor, here));
  }
  for (const WallContact& contact : here.wall_contacts.all)
    if (leaves(contact.sphere))
      parcel_for(contact.sphere)
          .wall_contacts.push_back(record_of(contact, here.spheres.id[index(contact.sphere)]));

  std::vector<Bytes> out;
  for (const Parcel& parcel : leaving)
    out.push_back(parcel.spheres.empty() ? Bytes{} : parcel.packed());
  for (const Bytes& bytes : communicator_.exchange(out))
    if (!bytes.empty()) arrived.push_back(unpacked(bytes));

  return keep_own(owner, here);
}

/// Appends as ghosts what of the other ranks may touch a sphere of this one.
void Domain::add_ghosts(const Box& box, double skin, Spheres& spheres) {
  const int me = communicator_.rank();
  const Decomposition::Part part = decomposition_.part_of(box, me);
  const std::vector<Extent> mine = extents_of(box, 0.5 * (part.lower + part.upper), spheres);
  Packer packer;
  packer.put_all(mine);
  const std::vector<Bytes> extents = communicator_.gather_to_all(packer.take());
  halo_.peers.clear();
  std::vector<Bytes> out(extents.size());
  for (int rank = 0; rank < communicator_.size(); ++rank) {
    if (rank == me) continue;
    const auto r = static_cast<std::size_t>(rank);
    std::vector<Extent> theirs = Unpacker(extents[r]).get_all<Extent>();
    std::erase_if(theirs, [&](const Extent& there) {
      return std::none_of(mine.begin(), mine.end(), [&](const Extent& extent) {
        return may_touch(box, skin, extent, there);
      });
    });
    Halo::Peer peer{rank, {}, {}, {}, {}};
    std::vector<SphereRecord> records;
    for (std::size_t i = 0; i < spheres.size(); ++i)
      if (std::any_of(theirs.begin(), theirs.end(), [&](const Extent& extent) {
            return may_touch(box, skin, spheres.motion[i], extent);
          })) {
        peer.out.push_back(static_cast<std::int32_t>(i));
        records.push_back(record_of(spheres, i));
      }
    Packer ghosts;
    ghosts.put_all(records);
    out[r] = ghosts.take();
    halo_.peers.push_back(std::move(peer));
  }
  const std::vector<Bytes> in = communicator_.exchange(out);
  for (Halo::Peer& peer : halo_.peers) {
    for (const SphereRecord& ghost :
         Unpacker(in[static_cast<std::size_t>(peer.rank)]).get_all<SphereRecord>()) {
      peer.in.push_back(static_cast<std::int32_t>(spheres.size()));
      append(ghost, ghost.is_of_clump != 0 ? kGhostOfClump : kGhost, spheres);
    }
    peer.out_numbers.resize(9 * peer.out.size());
    peer.in_numbers.resize(9 * peer.in.size());
  }
  std::erase_if(halo_.peers,
                [](const Halo::Peer& peer) { return peer.out.empty() && peer.in.empty(); });
}

Domain::Exchanged Domain::exchange(const Box& box, double skin, Population here) {
  const std::vector<int> owner = owners(here);
  const std::vector<std::int32_t> ids = here.spheres.id;
  std::vector<Parcel> parcels;
  Exchanged result{send_away(owner, here, parcels), {}};
  const auto stayed = static_cast<std::int32_t>(here.spheres.size());
  for (const Parcel& parcel : parcels)
    append_bodies(parcel, here.spheres, here.clumps, here.wall_contacts);
  add_ghosts(box, skin, here.spheres);
  std::unordered_map<std::int32_t, std::int32_t> came;  // index by id
  for (auto i = stayed; i < static_cast<std::int32_t>(here.spheres.size()); ++i)
    came[here.spheres.id[index(i)]] = i;

  // What a sphere that stayed touches is known here already; a contact of two newcomers may be.
  const std::vector<std::int32_t> sorted =
      sort_spheres(here.spheres, here.clumps, here.wall_contacts);
  halo_.follow_order(sorted);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    std::int32_t now = result.new_index[i];
    if (now == kGone) {
      const auto found = came.find(ids[i]);
      if (found != came.end()) now = found->second;
    }
    result.new_index[i] = now == kGone ? kGone : sorted[index(now)];
  }
  for (const Parcel& parcel : parcels)
    for (const PairContactRecord& record : parcel.contacts)
      if (came.contains(record.first) && came.contains(record.second))
        result.arrived.push_back(arrived_contact(contact_of(record),
                                                 sorted[index(came[record.first])],
                                                 sorted[index(came[record.second])]));
  return result;
}

}  // namespace repose::dem

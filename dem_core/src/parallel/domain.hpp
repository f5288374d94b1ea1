// The part of a simulation that one process holds, and what it knows of the others'.
#pragma once

#include <cstdint>
#include <vector>

#include "neighbor/neighbor_lists.hpp"
#include "parallel/decomposition.hpp"
#include "parallel/parcel.hpp"

namespace repose::dem {

/// All that processes share out: bodies, and contacts of these. Each process computes all forces on
/// its own spheres; the force between its own and a ghost is computed on both sides, from the same
/// numbers in the same order.
struct Population {
  Spheres& spheres;
  Clumps& clumps;
  NeighborLists& lists;
  ContactPool& pool;
  WallContacts& wall_contacts;
};

/// Which spheres of this process others know as ghosts, and the other way round.
class Halo {
 public:
  /// Brings positions and velocities of the ghosts to now and clears their loads.
  void update(const Communicator& communicator, Spheres& spheres);
  /// After spheres were taken out, the same everywhere: new_index of a sphere, -1 if it is gone.
  void follow_order(const std::vector<std::int32_t>& new_index);

  struct Peer {
    int rank;
    std::vector<std::int32_t> out;  ///< indices of spheres it knows as ghosts
    std::vector<std::int32_t> in;   ///< indices of ghosts from there
    std::vector<double> out_numbers, in_numbers;
  };
  std::vector<Peer> peers;
};

/// A contact that comes with a body.
struct ArrivedContact {
  std::int32_t i, j;  ///< indices of the spheres, i < j
  Contact contact;    ///< as i sees it
};

/// Begins those of these contacts that are not known in the lists yet.
void begin_contacts(const std::vector<ArrivedContact>& arrived, NeighborList& pairs,
                    ContactPool& pool);

/// The bodies of this process with what they cost in a step.
std::vector<WeightedPoint> weighted_bodies(const Population& here);

/// Who simulates what. With one process there is nothing to it.
class Domain {
 public:
  explicit Domain(const Communicator& communicator) : communicator_(communicator) {}

  const Communicator& communicator() const { return communicator_; }
  bool is_alone() const { return communicator_.is_alone(); }

  /// Where all processes hold all bodies: cuts the domain and keeps those of this rank. The lists
  /// must be empty; contacts with walls stay with their spheres.
  void share_out(const Box& box, Population here);
  /// Brings bodies to the rank whose part holds their centre, with their contacts, and makes ghosts
  /// of all that may touch a sphere of another rank before one has moved by skin/2. Returns the new
  /// index of each sphere that was known, -1 if it is gone, and the contacts that came along and
  /// were not known here.
  struct Exchanged {
    std::vector<std::int32_t> new_index;
    std::vector<ArrivedContact> arrived;
  };
  Exchanged exchange(const Box& box, double skin, Population here);
  /// Cuts the domain anew if the most costly rank is more than `worst` times as costly as the mean.
  void balance(const Box& box, const Population& here, double worst);

  void update_ghosts(Spheres& spheres) { halo_.update(communicator_, spheres); }
  void follow_order(const std::vector<std::int32_t>& new_index) { halo_.follow_order(new_index); }

  /// Bodies of this rank and the contacts that count here.
  static Parcel parcel_of(const Population& here);

  const Decomposition& decomposition() const { return decomposition_; }
  std::int64_t cuts() const { return cuts_; }

 private:
  std::vector<int> owners(const Population& here) const;
  std::vector<std::int32_t> keep_own(const std::vector<int>& owner, Population here) const;
  std::vector<std::int32_t> send_away(const std::vector<int>& owner, Population here,
                                      std::vector<Parcel>& arrived) const;
  void add_ghosts(const Box& box, double skin, Spheres& spheres);

  Communicator communicator_;
  Decomposition decomposition_;
  Halo halo_;
  std::int64_t cuts_ = 0;
};

}  // namespace repose::dem

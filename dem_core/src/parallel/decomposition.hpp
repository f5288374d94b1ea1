// Which process simulates which part of the domain.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/box.hpp"
#include "parallel/communicator.hpp"

namespace repose::dem {

/// A body as the decomposition sees it.
struct WeightedPoint {
  Vec3 x;
  std::int64_t cost;  ///< above 0, in any unit
};

/// The domain cut into boxes by recursive coordinate bisection [Berger1987]: each part is cut in
/// two across the direction in which fewest bodies face the cut, so that both sides cost the same
/// in proportion to the number of boxes that they are to become.
class Decomposition {
 public:
  Decomposition() = default;  ///< one box: all is rank 0's
  /// Cuts for `parts` ranks by the costs of the bodies of all processes; the same everywhere,
  /// however the bodies are spread over processes.
  Decomposition(const Box& box, const std::vector<WeightedPoint>& mine, int parts,
                const Communicator& communicator);

  int owner_of(const Vec3& x) const;
  /// Appends the ranks whose part comes closer to x than `distance`; images across periodic sides
  /// are not looked at.
  void add_ranks_within(const Vec3& x, double distance, std::vector<int>& ranks) const;
  /// The box of a rank: nothing beyond `box`.
  struct Part {
    Vec3 lower, upper;
  };
  Part part_of(const Box& box, int rank) const;

 private:
  struct Node {
    int axis = -1;  ///< -1: a leaf
    double cut = 0.0;
    int first_rank = 0, ranks = 1;
    int below = -1, above = -1;  ///< nodes
    Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();
  };

  std::vector<int> cut_level(const Box& box, const std::vector<WeightedPoint>& mine,
                             const std::vector<int>& nodes, std::vector<int>& node_of,
                             const Communicator& communicator);

  std::vector<Node> nodes_{Node{}};
};

/// Most costly over mean, of the ranks' costs; 1 if nothing costs anything.
double imbalance(std::int64_t mine, const Communicator& communicator);

}  // namespace repose::dem

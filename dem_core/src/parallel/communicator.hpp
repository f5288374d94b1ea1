// The processes that simulate one case together, each its part of the domain.
#pragma once

#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <span>
#include <vector>

#include "parallel/bytes.hpp"
#include "parallel/exact_sum.hpp"

namespace repose::dem {

/// This process alone, or all that a launcher of MPI started. Every function is collective: all
/// ranks call the same ones in the same order. With one rank nothing is sent and MPI is not called.
class Communicator {
 public:
  Communicator() = default;  ///< this process alone
  /// All processes of the launcher, while a ParallelSession lives; else this one alone.
  static Communicator of_launcher();

  int rank() const { return rank_; }
  int size() const { return size_; }
  bool is_root() const { return rank_ == 0; }
  bool is_alone() const { return size_ == 1; }

  /// The largest of all ranks, one by one.
  void maximize(std::span<double> values) const;
  /// Sums over all ranks, one by one; integers wrap.
  void add_up(std::span<std::int64_t> values) const;
  void add_up(std::span<ExactSum> values) const;

  /// What root has.
  Bytes broadcast(Bytes bytes) const;
  /// What each rank gave, in the order of ranks: on root (elsewhere nothing), on all.
  std::vector<Bytes> gather(const Bytes& mine) const;
  std::vector<Bytes> gather_to_all(const Bytes& mine) const;
  /// to[r] goes to rank r; returns what came from each.
  std::vector<Bytes> exchange(const std::vector<Bytes>& to) const;

  /// Buffers that go to a rank and come from one, neither being this one.
  struct Transfer {
    int rank;
    std::span<const double> out;
    std::span<double> in;
  };
  /// All at once; both ends know the lengths.
  void transfer(std::span<const Transfer> transfers) const;

  /// Does something on root alone. What it throws is thrown on all ranks, as the same type of
  /// Error.
  void on_root(const std::function<void()>& act) const;
  /// The same, with an answer that all ranks get.
  bool ask_root(const std::function<bool()>& question) const;
  /// Throws on all ranks what is pending on the lowest rank where something is.
  void rethrow(const std::exception_ptr& pending) const;
  /// Whether the last of these errors was thrown on all ranks.
  static bool all_know();

 private:
  Communicator(int rank, int size) : rank_(rank), size_(size) {}

  int rank_ = 0;
  int size_ = 1;
};

/// Whether a launcher of MPI started this process among others.
bool was_launched_in_parallel();

/// Initializes MPI for as long as it lives; the program must then call nothing of it before or
/// after.
class ParallelSession {
 public:
  ParallelSession(int* argc, char*** argv);
  ~ParallelSession();
  ParallelSession(const ParallelSession&) = delete;
  ParallelSession& operator=(const ParallelSession&) = delete;

  /// After an error on this rank: whether all ranks have come here, so that root may report for all
  /// and everybody may end. Waits for the others, long where they are known to come.
  bool all_failed() const;
  /// Ends all ranks at once.
  [[noreturn]] void abort(int exit_code) const;
};

}  // namespace repose::dem

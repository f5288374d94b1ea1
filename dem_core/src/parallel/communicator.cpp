#include "parallel/communicator.hpp"

#define OMPI_SKIP_MPICXX
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <optional>
#include <thread>
#include <utility>

#include "parallel/bytes.hpp"
#include "repose/base/error.hpp"

namespace repose::dem {
namespace {

constexpr int kTag = 1;
constexpr std::size_t kMostBytes = std::size_t{1} << 30;  // of one message

int count(std::size_t n) {
  return static_cast<int>(n);
}

/// Of ours alone, so that nothing else can be mistaken for our messages.
struct Communicators {
  MPI_Comm work = MPI_COMM_NULL;
  MPI_Comm errors = MPI_COMM_NULL;
};
Communicators& communicators() {
  static Communicators ours;
  return ours;
}
MPI_Comm work() {
  return communicators().work;
}

/// Appends what it takes to receive or send a buffer, in pieces that MPI can count.
template <class Post>
void post_pieces(std::size_t size, Post post) {
  for (std::size_t begin = 0; begin < size; begin += kMostBytes)
    post(begin, count(std::min(kMostBytes, size - begin)));
}

void receive(Bytes& into, int from, std::vector<MPI_Request>& requests) {
  post_pieces(into.size(), [&](std::size_t begin, int size) {
    MPI_Irecv(into.data() + begin, size, MPI_BYTE, from, kTag, work(), &requests.emplace_back());
  });
}
void send(const Bytes& bytes, int to, std::vector<MPI_Request>& requests) {
  post_pieces(bytes.size(), [&](std::size_t begin, int size) {
    MPI_Isend(bytes.data() + begin, size, MPI_BYTE, to, kTag, work(), &requests.emplace_back());
  });
}
void wait_for(std::vector<MPI_Request>& requests) {
  MPI_Waitall(count(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

/// An exception as bytes; no bytes for none.
Bytes packed(const std::exception_ptr& error) {
  Packer out;
  if (!error) return {};
  try {
    std::rethrow_exception(error);
  } catch (const Error& known) {
    out.put(known.exit_code());
    out.put_text(known.what());
  } catch (const std::exception& other) {
    out.put(static_cast<int>(ErrorKind::internal));
    out.put_text(other.what());
  }
  return out.take();
}

/// Long enough for ranks that fail by themselves, each in its own time, as with a bad case.
constexpr double kPatience_s = 30.0;
/// While root closes its files, say.
constexpr double kPatienceWithThoseWhoKnow_s = 600.0;

bool& error_of_all() {
  static bool is_of_all = false;
  return is_of_all;
}

[[noreturn]] void throw_packed(const Bytes& bytes) {
  error_of_all() = true;
  Unpacker in(bytes);
  const int code = in.get<int>();
  const std::string text = in.get_text();
  switch (static_cast<ErrorKind>(code)) {
    case ErrorKind::usage:
      throw UsageError(text);
    case ErrorKind::input:
      throw InputError(text);
    case ErrorKind::numerical:
      throw NumericalError(text);
    case ErrorKind::simulation:
      throw SimulationError(text);
    case ErrorKind::storage:
      throw StorageError(text);
    case ErrorKind::internal:
      break;
  }
  throw Error(ErrorKind::internal, text);
}

}  // namespace

Communicator Communicator::of_launcher() {
  if (work() == MPI_COMM_NULL) return {};
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(work(), &rank);
  MPI_Comm_size(work(), &size);
  return {rank, size};
}

void Communicator::maximize(std::span<double> values) const {
  if (is_alone()) return;
  MPI_Allreduce(MPI_IN_PLACE, values.data(), count(values.size()), MPI_DOUBLE, MPI_MAX, work());
}

void Communicator::add_up(std::span<std::int64_t> values) const {
  if (is_alone()) return;
  MPI_Allreduce(MPI_IN_PLACE, values.data(), count(values.size()), MPI_INT64_T, MPI_SUM, work());
}

void Communicator::add_up(std::span<ExactSum> values) const {
  if (is_alone()) return;
  Packer mine;
  for (const ExactSum& value : values) mine.put(value.parts());
  const std::vector<Bytes> all = gather_to_all(mine.take());
  std::fill(values.begin(), values.end(), ExactSum{});
  for (const Bytes& bytes : all) {
    Unpacker in(bytes);
    for (ExactSum& value : values) value.add(ExactSum(in.get<ExactSum::Parts>()));
  }
}

Bytes Communicator::broadcast(Bytes bytes) const {
  if (is_alone()) return bytes;
  std::uint64_t size = bytes.size();
  MPI_Bcast(&size, 1, MPI_UINT64_T, 0, work());
  bytes.resize(size);
  post_pieces(size, [&](std::size_t begin, int part) {
    MPI_Bcast(bytes.data() + begin, part, MPI_BYTE, 0, work());
  });
  return bytes;
}

std::vector<Bytes> Communicator::gather(const Bytes& mine) const {
  std::vector<Bytes> to(static_cast<std::size_t>(size_));
  to[0] = mine;
  std::vector<Bytes> from = exchange(to);
  if (!is_root()) from.clear();
  return from;
}

std::vector<Bytes> Communicator::gather_to_all(const Bytes& mine) const {
  if (is_alone()) return {mine};
  const auto ranks = static_cast<std::size_t>(size_);
  const std::uint64_t size = mine.size();
  std::vector<std::uint64_t> sizes(ranks);
  MPI_Allgather(&size, 1, MPI_UINT64_T, sizes.data(), 1, MPI_UINT64_T, work());
  std::vector<int> counts, offsets;
  std::uint64_t total = 0;
  for (const std::uint64_t of_rank : sizes) {
    counts.push_back(count(of_rank));
    offsets.push_back(count(total));
    total += of_rank;
  }
  if (total > kMostBytes) return exchange(std::vector<Bytes>(ranks, mine));
  Bytes all(total);
  MPI_Allgatherv(mine.data(), count(size), MPI_BYTE, all.data(), counts.data(), offsets.data(),
                 MPI_BYTE, work());
  std::vector<Bytes> from;
  for (std::size_t r = 0; r < ranks; ++r)
    from.emplace_back(all.begin() + offsets[r], all.begin() + offsets[r] + counts[r]);
  return from;
}

std::vector<Bytes> Communicator::exchange(const std::vector<Bytes>& to) const {
  if (is_alone()) return to;
  const auto ranks = static_cast<std::size_t>(size_);
  std::vector<std::uint64_t> out(ranks), in(ranks);
  for (std::size_t r = 0; r < ranks; ++r) out[r] = to[r].size();
  MPI_Alltoall(out.data(), 1, MPI_UINT64_T, in.data(), 1, MPI_UINT64_T, work());
  std::vector<Bytes> from(ranks);
  std::vector<MPI_Request> requests;
  for (int r = 0; r < size_; ++r) {
    const auto k = static_cast<std::size_t>(r);
    if (r == rank_) {
      from[k] = to[k];
      continue;
    }
    from[k].resize(in[k]);
    receive(from[k], r, requests);
  }
  for (int r = 0; r < size_; ++r)
    if (r != rank_) send(to[static_cast<std::size_t>(r)], r, requests);
  wait_for(requests);
  return from;
}

void Communicator::transfer(std::span<const Transfer> transfers) const {
  if (transfers.empty()) return;
  std::vector<MPI_Request> requests;
  requests.reserve(2 * transfers.size());
  for (const Transfer& t : transfers)
    if (!t.in.empty())
      MPI_Irecv(t.in.data(), count(t.in.size()), MPI_DOUBLE, t.rank, kTag, work(),
                &requests.emplace_back());
  for (const Transfer& t : transfers)
    if (!t.out.empty())
      MPI_Isend(t.out.data(), count(t.out.size()), MPI_DOUBLE, t.rank, kTag, work(),
                &requests.emplace_back());
  wait_for(requests);
}

void Communicator::on_root(const std::function<void()>& act) const {
  if (is_alone()) return act();
  std::exception_ptr error;
  if (is_root()) {
    try {
      act();
    } catch (...) {
      error = std::current_exception();
    }
  }
  const Bytes told = broadcast(packed(error));
  if (error) {
    error_of_all() = true;
    std::rethrow_exception(error);
  }
  if (!told.empty()) throw_packed(told);
}

bool Communicator::ask_root(const std::function<bool()>& question) const {
  double answer[1] = {0.0};
  on_root([&] { answer[0] = question() ? 1.0 : 0.0; });
  maximize(answer);
  return answer[0] > 0.0;
}

bool Communicator::all_know() {
  return error_of_all();
}

void Communicator::rethrow(const std::exception_ptr& pending) const {
  if (is_alone()) {
    if (pending) std::rethrow_exception(pending);
    return;
  }
  for (const Bytes& told : gather_to_all(packed(pending)))
    if (!told.empty()) throw_packed(told);
}

bool was_launched_in_parallel() {
  const char* const size = std::getenv("OMPI_COMM_WORLD_SIZE");
  if (size != nullptr) return std::atoi(size) > 1;
  return std::getenv("PMI_SIZE") != nullptr || std::getenv("PMIX_RANK") != nullptr;
}

ParallelSession::ParallelSession(int* argc, char*** argv) {
  MPI_Init(argc, argv);
  MPI_Comm_dup(MPI_COMM_WORLD, &communicators().work);
  MPI_Comm_dup(MPI_COMM_WORLD, &communicators().errors);
}

ParallelSession::~ParallelSession() {
  MPI_Finalize();
  communicators() = {};
}

bool ParallelSession::all_failed() const {
  const double seconds = Communicator::all_know() ? kPatienceWithThoseWhoKnow_s : kPatience_s;
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(communicators().errors, &request);
  const auto begin = std::chrono::steady_clock::now();
  for (;;) {
    int done = 0;
    MPI_Test(&request, &done, MPI_STATUS_IGNORE);
    if (done != 0) return true;
    const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - begin;
    if (waited.count() > seconds) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

void ParallelSession::abort(int exit_code) const {
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::abort();
}

}  // namespace repose::dem

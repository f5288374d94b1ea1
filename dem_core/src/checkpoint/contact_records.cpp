#include "checkpoint/contact_records.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "repose/base/error.hpp"

namespace repose::dem {
namespace {

std::size_t index(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

std::pair<std::int32_t, std::int32_t> ids_of(const ContactRecord& record) {
  return {record.first, record.second};
}

}  // namespace

ContactHistory seen_from_the_other(const ContactHistory& history) {
  return {-history.slip, -history.rolling};
}

ContactRecord contact_record(const Neighbor& neighbor, const Spheres& spheres,
                             const ContactPool& pool) {
  const Contact& contact = pool.at(neighbor.contact);
  const std::int32_t a = spheres.id[index(neighbor.row)];
  const std::int32_t b = spheres.id[index(neighbor.other)];
  if (a < b) return {a, b, contact.history, contact.stored_j};
  return {b, a, seen_from_the_other(contact.history), contact.stored_j};
}

std::vector<ContactRecord> contact_records(const Spheres& spheres, const NeighborList& pairs,
                                           const ContactPool& pool) {
  std::vector<ContactRecord> records;
  records.reserve(pool.size());
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::int32_t p = pairs.first[i]; p < pairs.first[i + 1]; ++p) {
      const Neighbor& neighbor = pairs.entries[index(p)];
      if (neighbor.contact == kNoContact || spheres.is_ghost(i)) continue;
      records.push_back(contact_record(neighbor, spheres, pool));
    }
  sort(records);
  return records;
}

void sort(std::vector<ContactRecord>& records) {
  std::sort(records.begin(), records.end(),
            [](const ContactRecord& a, const ContactRecord& b) { return ids_of(a) < ids_of(b); });
}

void begin_contacts(const std::vector<ContactRecord>& records, const Spheres& spheres,
                    NeighborList& pairs, ContactPool& pool) {
  std::size_t begun = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::int32_t p = pairs.first[i]; p < pairs.first[i + 1]; ++p) {
      Neighbor& neighbor = pairs.entries[index(p)];
      const std::size_t j = index(neighbor.other);
      const std::int32_t a = spheres.id[i];
      const std::int32_t b = spheres.id[j];
      const std::pair<std::int32_t, std::int32_t> ids = std::minmax(a, b);
      const auto record = std::lower_bound(
          records.begin(), records.end(), ids,
          [](const ContactRecord& r, const auto& wanted) { return ids_of(r) < wanted; });
      if (record == records.end() || ids_of(*record) != ids) continue;
      neighbor.contact = pool.begin_contact();
      Contact& contact = pool.at(neighbor.contact);
      contact.history = a < b ? record->history : seen_from_the_other(record->history);
      contact.stored_j = record->stored_j;
      ++begun;
    }
  if (begun != records.size())
    throw StorageError("a checkpoint has " + std::to_string(records.size() - begun) +
                       " contacts of spheres that are apart; begin the run anew");
}

}  // namespace repose::dem

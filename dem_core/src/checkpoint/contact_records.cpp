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

ContactHistory seen_from_the_other(const ContactHistory& history) {
  return {-history.slip, -history.rolling};
}

std::pair<std::int32_t, std::int32_t> ids_of(const ContactRecord& record) {
  return {record.first, record.second};
}

}  // namespace

std::vector<ContactRecord> contact_records(const Spheres& spheres, const NeighborList& pairs,
                                           const ContactPool& pool) {
  std::vector<ContactRecord> records;
  records.reserve(pool.size());
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::int32_t p = pairs.first[i]; p < pairs.first[i + 1]; ++p) {
      const Neighbor& neighbor = pairs.entries[index(p)];
      if (neighbor.contact == kNoContact) continue;
      const Contact& contact = pool.at(neighbor.contact);
      const std::int32_t a = spheres.id[i];
      const std::int32_t b = spheres.id[index(neighbor.other)];
      if (a < b)
        records.push_back({a, b, contact.history, contact.stored_j});
      else
        records.push_back({b, a, seen_from_the_other(contact.history), contact.stored_j});
    }
  std::sort(records.begin(), records.end(),
            [](const ContactRecord& a, const ContactRecord& b) { return ids_of(a) < ids_of(b); });
  return records;
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

void reorder_lists(const std::vector<std::int32_t>& order, NeighborLists& lists) {
  const std::size_t n = order.size();
  std::vector<std::int32_t> new_index(n);
  for (std::size_t k = 0; k < n; ++k) new_index[index(order[k])] = static_cast<std::int32_t>(k);
  std::vector<std::vector<std::int32_t>> rows(n);
  for (std::size_t i = 0; i < n; ++i)
    for (std::int32_t p = lists.pairs.first[i]; p < lists.pairs.first[i + 1]; ++p) {
      const auto [a, b] =
          std::minmax(new_index[i], new_index[index(lists.pairs.entries[index(p)].other)]);
      rows[index(a)].push_back(b);
    }
  NeighborLists sorted;
  for (std::size_t k = 0; k < n; ++k) {
    std::sort(rows[k].begin(), rows[k].end());
    sorted.pairs.first.push_back(static_cast<std::int32_t>(sorted.pairs.entries.size()));
    for (const std::int32_t other : rows[k]) sorted.pairs.entries.push_back({other, kNoContact});
    sorted.walls.first.push_back(static_cast<std::int32_t>(sorted.walls.facets.size()));
    const auto row = lists.walls.row(index(order[k]));
    sorted.walls.facets.insert(sorted.walls.facets.end(), row.begin(), row.end());
  }
  sorted.pairs.first.push_back(static_cast<std::int32_t>(sorted.pairs.entries.size()));
  sorted.walls.first.push_back(static_cast<std::int32_t>(sorted.walls.facets.size()));
  lists = std::move(sorted);
}

}  // namespace repose::dem

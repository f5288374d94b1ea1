// Contacts by the ids of those that touch: what outlives the order of spheres in memory.
#pragma once

#include <vector>

#include "neighbor/neighbor_lists.hpp"

namespace repose::dem {

/// A contact of two spheres, as the one of the smaller id sees it.
struct ContactRecord {
  std::int32_t first, second;  ///< ids, first < second
  ContactHistory history;
  double stored_j;
};

/// A contact as the other sphere of the pair sees it.
ContactHistory seen_from_the_other(const ContactHistory& history);

/// The record of a neighbor that touches.
ContactRecord contact_record(const Neighbor& neighbor, const Spheres& spheres,
                             const ContactPool& pool);

/// All contacts of pairs whose first sphere is simulated here, by ascending ids.
std::vector<ContactRecord> contact_records(const Spheres& spheres, const NeighborList& pairs,
                                           const ContactPool& pool);

/// By ascending ids.
void sort(std::vector<ContactRecord>& records);

/// Begins these contacts in lists without any. Throws StorageError for a pair that is not listed.
void begin_contacts(const std::vector<ContactRecord>& records, const Spheres& spheres,
                    NeighborList& pairs, ContactPool& pool);

}  // namespace repose::dem

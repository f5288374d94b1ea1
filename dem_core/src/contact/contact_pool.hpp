// Records of the contacts that exist, addressed from the neighbor lists.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "parallel/exact_sum.hpp"
#include "repose/dem/contact_law.hpp"

namespace repose::dem {

inline constexpr std::int32_t kNoContact = -1;

/// One cache line; the kernels see it as eight numbers.
struct alignas(64) Contact {
  ContactHistory history;
  double stored_j = 0.0;  ///< when energies were last asked for
  double unused = 0.0;
};
static_assert(sizeof(Contact) == 64);

/// Slots with a free list; a new contact gets the slot freed last.
class ContactPool {
 public:
  std::int32_t begin_contact() {
    std::int32_t slot;
    if (free_.empty()) {
      slot = static_cast<std::int32_t>(contacts_.size());
      contacts_.emplace_back();
    } else {
      slot = free_.back();
      free_.pop_back();
    }
    at(slot) = Contact{};
    return slot;
  }
  void end_contact(std::int32_t slot) { free_.push_back(slot); }
  /// Counts what a contact that ends still stores; it is lost.
  void count_released(std::int32_t slot) { released_j_.add(at(slot).stored_j); }
  ExactSum& released_j() { return released_j_; }
  Contact& at(std::int32_t slot) { return contacts_[static_cast<std::size_t>(slot)]; }
  const Contact& at(std::int32_t slot) const { return contacts_[static_cast<std::size_t>(slot)]; }
  Contact* data() { return contacts_.data(); }
  std::size_t size() const { return contacts_.size() - free_.size(); }

  /// An empty pool with room for as many contacts as this one holds.
  ContactPool emptied() const {
    ContactPool pool;
    pool.contacts_.reserve(contacts_.size());
    pool.released_j_ = released_j_;
    return pool;
  }
  /// Appends a contact; for pools without freed slots.
  std::int32_t append(const Contact& contact) {
    contacts_.push_back(contact);
    return static_cast<std::int32_t>(contacts_.size() - 1);
  }

 private:
  std::vector<Contact> contacts_;
  std::vector<std::int32_t> free_;
  ExactSum released_j_;
};

}  // namespace repose::dem

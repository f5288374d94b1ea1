#include "contact/wall_contacts.hpp"

#include <algorithm>

namespace repose::dem {

template <class Predicate>
void WallContacts::erase_ended(Predicate&& has_ended) {
  for (const WallContact& contact : all)
    if (has_ended(contact)) released_j.add(contact.contact.stored_j);
  std::erase_if(all, has_ended);
}

void WallContacts::follow_order(const std::vector<std::int32_t>& new_index) {
  for (WallContact& contact : all)
    contact.sphere = new_index[static_cast<std::size_t>(contact.sphere)];
  erase_ended([](const WallContact& contact) { return contact.sphere < 0; });
  std::stable_sort(all.begin(), all.end(),
                   [](const WallContact& a, const WallContact& b) { return a.sphere < b.sphere; });
}

void WallContacts::end_with(std::int32_t wall) {
  erase_ended([wall](const WallContact& contact) { return contact.wall == wall; });
}

}  // namespace repose::dem

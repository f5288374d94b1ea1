#include "contact/wall_contacts.hpp"

#include <algorithm>

namespace repose::dem {

void WallContacts::follow_order(const std::vector<std::int32_t>& new_index) {
  for (WallContact& contact : all)
    contact.sphere = new_index[static_cast<std::size_t>(contact.sphere)];
  std::erase_if(all, [](const WallContact& contact) { return contact.sphere < 0; });
  std::stable_sort(all.begin(), all.end(),
                   [](const WallContact& a, const WallContact& b) { return a.sphere < b.sphere; });
}

void WallContacts::end_with(std::int32_t wall) {
  std::erase_if(all, [wall](const WallContact& contact) { return contact.wall == wall; });
}

}  // namespace repose::dem

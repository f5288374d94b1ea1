#include "particles/spheres.hpp"

namespace repose::dem {
namespace {

template <class T>
void select_from(const std::vector<std::int32_t>& order, std::vector<T>& values) {
  std::vector<T> selected;
  selected.reserve(order.size());
  for (std::int32_t old : order) selected.push_back(values[static_cast<std::size_t>(old)]);
  values.swap(selected);
}

}  // namespace

void Spheres::select(const std::vector<std::int32_t>& order) {
  select_from(order, motion);
  select_from(order, spin);
  select_from(order, load);
  select_from(order, x_listed);
  select_from(order, material);
  select_from(order, id);
  select_from(order, body);
  select_from(order, member);
  select_from(order, mass);
  select_from(order, key);
}

}  // namespace repose::dem

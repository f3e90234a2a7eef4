/// \file
/// Things that have a name each: bodies, joints, muscles, parameters.
#pragma once

#include <cstddef>
#include <string_view>

namespace simgap {

/// The place of the one with this name, -1 for none. \param items  whose elements have a member `name`
template <class Items>
int indexOf(const Items& items, std::string_view name) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace simgap

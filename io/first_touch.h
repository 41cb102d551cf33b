// Memory that several threads take from the system together.
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace orbweave {

/// Writes to every page of a block that holds nothing yet. The kernel clears a page when it is
/// written for the first time, which takes longer than filling the page: the threads of the calling
/// thread's TBB arena share that.
void touch_pages(void* block, std::size_t bytes);

/// Room for `size` elements, of which each will be used: pages that are touched are held. Nothing
/// where the room is there.
template <class T, class Allocator>
void reserve_touched(std::vector<T, Allocator>& elements, std::size_t size) {
  if (size <= elements.capacity()) return;
  elements.reserve(size);
  touch_pages(elements.data() + elements.size(), (size - elements.size()) * sizeof(T));
}

/// Leaves new elements of a type without initial values as they are.
template <class T>
struct UnsetAllocator : std::allocator<T> {
  template <class Other>
  struct rebind {
    using other = UnsetAllocator<Other>;
  };
  template <class Element>
  void construct(Element* place) {
    ::new (static_cast<void*>(place)) Element;
  }
  template <class Element, class... Arguments>
  void construct(Element* place, Arguments&&... arguments) {
    std::construct_at(place, std::forward<Arguments>(arguments)...);
  }
};

/// A list whose resize() writes nothing: several threads fill it next, and take its pages. A loop
/// that ends early leaves values at random: check_loops_are_whole() comes before the first use of
/// the values that is not such a loop.
template <class T>
using UnsetVector = std::vector<T, UnsetAllocator<T>>;

}  // namespace orbweave

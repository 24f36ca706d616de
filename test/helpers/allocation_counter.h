// Counts operator new. A test program includes this once: it replaces the operators of the whole process, its libraries
// included. Pixel buffers of OpenCV have an allocator of their own and are not counted.
#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<long> g_allocations{0};  // OpenCV's threads allocate as well

void* countedAllocation(size_t size, size_t alignment) {
  g_allocations.fetch_add(1, std::memory_order_relaxed);
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, size) != 0) throw std::bad_alloc();
  return memory;
}
}  // namespace

// Not inlined, or the compiler takes new and delete for a mismatched pair.
[[gnu::noinline]] void* operator new(size_t size) { return countedAllocation(size, alignof(std::max_align_t)); }
[[gnu::noinline]] void* operator new(size_t size, std::align_val_t alignment) {
  return countedAllocation(size, static_cast<size_t>(alignment));
}
// AddressSanitizer's would not call ours, and what it hands out must not reach std::free; std::stable_sort asks for it.
[[gnu::noinline]] void* operator new(size_t size, const std::nothrow_t&) noexcept {
  try {
    return operator new(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, size_t, std::align_val_t) noexcept { std::free(memory); }

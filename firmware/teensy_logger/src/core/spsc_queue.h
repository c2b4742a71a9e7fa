// A queue between one producer and one consumer, where either may interrupt the other.
#pragma once

#include <stdint.h>

#include <atomic>

namespace tfsat {
namespace logger {

template <typename T, uint32_t kCapacity>
class SpscQueue {
  static_assert((kCapacity & (kCapacity - 1)) == 0, "indices wrap at a power of two");

 public:
  // Producer. False, and nothing changed, when full.
  bool push(const T& item) {
    const uint32_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == kCapacity) return false;
    items_[head % kCapacity] = item;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  // Producer. No item fits.
  bool full() const {
    const uint32_t head = head_.load(std::memory_order_relaxed);
    return head - tail_.load(std::memory_order_acquire) == kCapacity;
  }

  // Producer. Items that fit at least.
  uint32_t room() const {
    return kCapacity -
           (head_.load(std::memory_order_relaxed) - tail_.load(std::memory_order_acquire));
  }

  // Consumer. The oldest item, or nullptr.
  const T* front() const {
    const uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return nullptr;
    return &items_[tail % kCapacity];
  }

  // Consumer. Frees the oldest item; there must be one.
  void pop() { tail_.store(tail_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  // Consumer. Forgets everything.
  void clear() { tail_.store(head_.load(std::memory_order_acquire), std::memory_order_release); }

 private:
  T items_[kCapacity];
  std::atomic<uint32_t> head_{0};
  std::atomic<uint32_t> tail_{0};
};

}  // namespace logger
}  // namespace tfsat

// Blocks that wait for the card: filled in place by the sampling interrupt, emptied by the main
// loop.
//
// Cards stall for 200 ms often and may for 500 ms; the ring is what keeps a stall from costing
// samples.
#pragma once

#include <stdint.h>

#include <atomic>

#include "../protocol/messages.h"

namespace tfsat {
namespace logger {

// Aligned for drivers that move words or use DMA (cache line of the Cortex-M7: 32 bytes).
struct alignas(32) Block {
  uint8_t bytes[protocol::kBlockBytes];
};

// Blocks for this long without a card, rounded up to the power of two that the ring needs.
constexpr uint32_t ring_blocks_for(uint32_t seconds, uint32_t rate_hz) {
  const uint32_t needed = seconds * rate_hz / protocol::kSamplesPerBlock + 1;
  uint32_t blocks = 1;
  while (blocks < needed) blocks *= 2;
  return blocks;
}

// 3 s at 1 kHz: 512 blocks, 256 KiB; 10.9 s at 280 Hz. Up to kCardSyncMs of them are with the card
// already and wait to be safe there.
constexpr uint32_t kRingBlocks = ring_blocks_for(3, 1000);

// Single producer, single consumer, no lock. The memory is the caller's.
class BlockRing {
 public:
  // `capacity` must be a power of two.
  BlockRing(Block* blocks, uint32_t capacity) : blocks_(blocks), capacity_(capacity) {}

  // Producer. The next free block to fill, the same one until commit(); nullptr when all are taken.
  Block* acquire() {
    const uint32_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == capacity_) return nullptr;
    return &blocks_[head % capacity_];
  }

  // Producer. Hands the acquired block to the consumer.
  void commit() {
    const uint32_t head = head_.load(std::memory_order_relaxed) + 1;
    head_.store(head, std::memory_order_release);
    const uint32_t waiting = head - tail_.load(std::memory_order_acquire);
    if (waiting > peak_.load(std::memory_order_relaxed)) {
      peak_.store(waiting, std::memory_order_relaxed);
    }
  }

  // Consumer. The block behind the `n` oldest, or nullptr.
  const Block* peek(uint32_t n) const {
    const uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (head_.load(std::memory_order_acquire) - tail <= n) return nullptr;
    return &blocks_[(tail + n) % capacity_];
  }
  // Consumer. The oldest block, or nullptr.
  const Block* front() const { return peek(0); }

  // Consumer. Frees the `n` oldest blocks; there must be as many.
  void release(uint32_t n = 1) {
    tail_.store(tail_.load(std::memory_order_relaxed) + n, std::memory_order_release);
  }

  uint32_t waiting() const {
    return head_.load(std::memory_order_acquire) - tail_.load(std::memory_order_acquire);
  }
  // Most blocks that ever waited since reset().
  uint32_t peak() const { return peak_.load(std::memory_order_relaxed); }
  uint32_t capacity() const { return capacity_; }

  // Empties the ring. Only while nobody produces.
  void reset() {
    tail_.store(head_.load(std::memory_order_acquire), std::memory_order_release);
    peak_.store(0, std::memory_order_relaxed);
  }

 private:
  Block* blocks_;
  uint32_t capacity_;
  std::atomic<uint32_t> head_{0};
  std::atomic<uint32_t> tail_{0};
  std::atomic<uint32_t> peak_{0};
};

}  // namespace logger
}  // namespace tfsat

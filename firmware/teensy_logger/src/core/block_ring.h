// Blocks that wait for the card: filled in place by the sampling interrupt, emptied by the main
// loop.
//
// Cards stall for 200 ms often and may for 500 ms; the ring is what keeps a stall from costing
// samples. A block that the card has stays readable until its room is needed again, so the ring is
// also the memory of the last seconds.
#pragma once

#include <stdint.h>
#include <string.h>

#include <atomic>

#include "../protocol/messages.h"

namespace tfsat {
namespace logger {

// Aligned for drivers that move words or use DMA (cache line of the Cortex-M7: 32 bytes).
struct alignas(32) Block {
  uint8_t bytes[protocol::kBlockBytes];
};

// 448 KiB of the Teensy's RAM2, which the USB buffers share: 5.3 s at 1 kHz, 19 s at 280 Hz. A drop
// from a second before the release to four seconds after it fits at every rate.
using protocol::kRingBlocks;
static_assert(kRingBlocks * protocol::kSamplesPerBlock >=
                  (protocol::kRewriteBeforeReleaseUs + protocol::kRewriteAfterReleaseUs) /
                      (1000000u / protocol::kSampleRateMaxHz),
              "a whole drop stays in RAM");

// Single producer, single consumer, no lock. The memory is the caller's.
class BlockRing {
 public:
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
  // Consumer. Copies block `index` (counted since reset()) if it is still there whole: the producer
  // fills block committed() and with it overwrites the one `capacity` before.
  bool copy(uint32_t index, Block& out) const {
    if (committed() - index > capacity_ || index >= committed()) return false;
    memcpy(out.bytes, blocks_[index % capacity_].bytes, sizeof out.bytes);
    std::atomic_signal_fence(std::memory_order_seq_cst);
    return committed() - index < capacity_;
  }
  // Consumer. The oldest block that copy() may still give.
  uint32_t oldest() const {
    const uint32_t made = committed();
    return made < capacity_ ? 0 : made - capacity_ + 1;
  }
  // Blocks handed over since reset().
  uint32_t committed() const { return head_.load(std::memory_order_acquire); }

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
    head_.store(0, std::memory_order_relaxed);
    tail_.store(0, std::memory_order_release);
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

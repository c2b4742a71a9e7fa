// Ring and queue: order, bounds, and a producer and a consumer at full speed in two threads.
#include <thread>
#include <vector>

#include "../../firmware/teensy_logger/src/core/block_ring.h"
#include "../../firmware/teensy_logger/src/core/spsc_queue.h"
#include "check.h"

using tfsat::logger::Block;
using tfsat::logger::BlockRing;
using tfsat::logger::SpscQueue;

TEST_CASE(ring_holds_a_drop_at_1_khz) {
  using namespace tfsat::protocol;
  constexpr uint32_t kDropSamples = (kRewriteBeforeReleaseUs + kRewriteAfterReleaseUs) / 1000;
  CHECK(tfsat::logger::kRingBlocks * kSamplesPerBlock >= kDropSamples + kDropSamples / 20);
}

TEST_CASE(ring_of_any_capacity_goes_round) {
  for (const uint32_t capacity : {3u, 7u, 10u}) {
    std::vector<Block> memory(capacity);
    BlockRing ring(memory.data(), capacity);
    uint8_t next = 0;
    for (uint32_t round = 0; round < 50; ++round) {
      for (uint32_t i = 0; i < 1 + round % capacity; ++i) {
        ring.acquire()->bytes[511] = static_cast<uint8_t>(ring.committed());
        ring.commit();
      }
      const uint32_t n = ring.waiting();
      for (uint32_t i = 0; i < n; ++i) {
        CHECK(ring.peek(i)->bytes[511] == static_cast<uint8_t>(next + i));
      }
      CHECK(ring.peek(n) == nullptr);
      ring.release(n);
      next = static_cast<uint8_t>(next + n);
    }
  }
}

TEST_CASE(ring_gives_copies_of_blocks_that_are_still_whole) {
  std::vector<Block> memory(5);
  BlockRing ring(memory.data(), 5);
  Block out;
  CHECK(ring.oldest() == 0 && !ring.copy(0, out));
  for (uint8_t i = 0; i < 12; ++i) {
    ring.acquire()->bytes[0] = i;
    ring.commit();
    ring.release();
    const uint32_t made = i + 1u;
    CHECK(ring.oldest() == (made < 5 ? 0 : made - 4));  // the fifth may be being overwritten
    for (uint32_t k = 0; k < made + 2; ++k) {
      const bool given = ring.copy(k, out);
      CHECK(given == (k >= ring.oldest() && k < made));
      CHECK(!given || out.bytes[0] == k);
    }
  }
}

TEST_CASE(ring_refuses_when_full_and_gives_blocks_back_in_order) {
  std::vector<Block> memory(4);
  BlockRing ring(memory.data(), 4);
  CHECK(ring.front() == nullptr);
  for (uint8_t i = 0; i < 4; ++i) {
    Block* block = ring.acquire();
    CHECK(block != nullptr && ring.acquire() == block);
    block->bytes[0] = i;
    ring.commit();
  }
  CHECK(ring.acquire() == nullptr);
  CHECK(ring.waiting() == 4 && ring.peak() == 4);
  for (uint8_t i = 0; i < 4; ++i) {
    CHECK(ring.front()->bytes[0] == i);
    ring.release();
  }
  CHECK(ring.front() == nullptr && ring.waiting() == 0 && ring.peak() == 4);
  ring.reset();
  CHECK(ring.peak() == 0);
}

TEST_CASE(ring_keeps_every_block_between_two_threads) {
  constexpr uint32_t kBlocks = 20000;
  std::vector<Block> memory(8);
  BlockRing ring(memory.data(), 8);
  std::thread producer([&ring] {
    for (uint32_t i = 0; i < kBlocks;) {
      Block* block = ring.acquire();
      if (block == nullptr) {
        std::this_thread::yield();
        continue;
      }
      for (uint8_t& byte : block->bytes) byte = static_cast<uint8_t>(i);
      ring.commit();
      ++i;
    }
  });
  uint32_t wrong = 0;
  for (uint32_t i = 0; i < kBlocks;) {
    const Block* block = ring.front();
    if (block == nullptr) {
      std::this_thread::yield();
      continue;
    }
    for (const uint8_t byte : block->bytes) wrong += byte != static_cast<uint8_t>(i);
    ring.release();
    ++i;
  }
  producer.join();
  CHECK(wrong == 0);
  CHECK(ring.waiting() == 0 && ring.peak() <= 8);
}

TEST_CASE(queue_is_first_in_first_out_and_bounded) {
  SpscQueue<int, 4> queue;
  CHECK(queue.front() == nullptr);
  for (int i = 0; i < 4; ++i) CHECK(queue.push(i));
  CHECK(queue.full() && !queue.push(4));
  CHECK(*queue.front() == 0);
  queue.pop();
  CHECK(queue.push(4));
  for (int i = 1; i <= 4; ++i) {
    CHECK(*queue.front() == i);
    queue.pop();
  }
  CHECK(queue.front() == nullptr);
  queue.push(5);
  queue.clear();
  CHECK(queue.front() == nullptr);
}

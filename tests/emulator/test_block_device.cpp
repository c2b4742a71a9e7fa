#include "card/block_device.h"

#include <cstdio>
#include <cstring>
#include <vector>

#include "check.h"

using namespace tfsat::emulator;

namespace {

struct Block {
  uint8_t bytes[BlockDevice::kBlockBytes];
  explicit Block(uint8_t fill) { std::memset(bytes, fill, sizeof bytes); }
};

CardParameters instant(uint32_t cache_blocks) {
  CardParameters p;
  p.write_us = p.sync_us = 0;
  p.cache_blocks = cache_blocks;
  return p;
}

bool holds(const BlockDevice& card, uint32_t index, uint8_t value, size_t offset = 0) {
  return card.bytes()[index * BlockDevice::kBlockBytes + offset] == value;
}

}  // namespace

TEST_CASE(card_is_busy_after_a_write_and_while_it_stalls) {
  CardParameters p;
  p.write_us = 250;
  p.sync_us = 1000;
  BlockDevice card(p);
  const Block block(1);
  CHECK(card.preallocate(4) == CardResult::kOk);
  CHECK(card.write(1000, 0, block.bytes) == CardResult::kOk);
  CHECK(card.write(1249, 1, block.bytes) == CardResult::kBusy);
  CHECK(card.write(1250, 1, block.bytes) == CardResult::kOk);
  CHECK(card.sync(1500) == CardResult::kOk);
  CHECK(card.busy(2499));
  card.stall_until(500000);
  CHECK(card.sync(499999) == CardResult::kBusy);
  CHECK(!card.busy(500000));
  CHECK(card.blocks_written() == 2);
}

TEST_CASE(card_refuses_blocks_beyond_its_file_and_is_absent_when_pulled) {
  BlockDevice card(instant(0));
  const Block block(1);
  CHECK(card.write(0, 0, block.bytes) == CardResult::kOutOfRange);
  card.preallocate(2);
  CHECK(card.write(0, 2, block.bytes) == CardResult::kOutOfRange);
  card.set_present(false);
  CHECK(card.write(0, 0, block.bytes) == CardResult::kAbsent);
  CHECK(card.sync(0) == CardResult::kAbsent);
  CHECK(card.preallocate(9) == CardResult::kAbsent);
  CHECK(card.truncate(0) == CardResult::kAbsent);
  CHECK(card.n_blocks() == 2);
}

TEST_CASE(a_power_cut_takes_what_was_not_synced) {
  BlockDevice card(instant(2));
  card.preallocate(6);
  for (uint32_t i = 0; i < 3; ++i)
    card.write(0, i, Block(static_cast<uint8_t>(i + 1)).bytes);
  CHECK(card.unsynced_blocks() == 2);
  CHECK(holds(card, 2, 3));
  card.sync(0);
  card.write(0, 3, Block(4).bytes);
  card.power_cut(PowerCut::kLosesCache);
  CHECK(holds(card, 2, 3));
  CHECK(holds(card, 3, 0));
}

TEST_CASE(a_card_out_of_its_contacts_loses_what_was_not_synced) {
  BlockDevice card(instant(2));
  card.preallocate(2);
  card.write(0, 0, Block(1).bytes);
  card.sync(0);
  card.write(0, 1, Block(2).bytes);
  card.set_present(false);
  card.set_present(true);
  CHECK(holds(card, 0, 1) && holds(card, 1, 0));
}

TEST_CASE(a_power_cut_can_tear_a_block) {
  BlockDevice card(instant(2));
  card.preallocate(2);
  card.write(0, 0, Block(1).bytes);
  card.sync(0);
  card.write(0, 0, Block(9).bytes);
  card.write(0, 1, Block(9).bytes);
  card.power_cut(PowerCut::kTearsOldestInCache);
  CHECK(holds(card, 0, 9, 255));
  CHECK(holds(card, 0, 1, 256));
  CHECK(holds(card, 1, 0));
}

TEST_CASE(without_a_cache_nothing_written_is_lost) {
  BlockDevice card(instant(0));
  card.preallocate(1);
  card.write(0, 0, Block(5).bytes);
  card.power_cut(PowerCut::kTearsOldestInCache);
  CHECK(holds(card, 0, 5, 511));
}

TEST_CASE(a_clean_stop_shortens_the_file_and_keeps_the_last_blocks) {
  BlockDevice card(instant(4));
  card.preallocate(100);
  card.write(0, 0, Block(1).bytes);
  card.write(0, 1, Block(2).bytes);
  CHECK(card.truncate(2) == CardResult::kOk);
  CHECK(card.unsynced_blocks() == 0);
  CHECK(card.bytes().size() == 1024);
  CHECK(holds(card, 1, 2));
  CHECK(card.truncate(50) == CardResult::kOk);
  CHECK(card.n_blocks() == 2);
}

TEST_CASE(the_file_survives_saving_and_loading) {
  BlockDevice card(instant(4));
  card.preallocate(3);
  card.write(0, 2, Block(7).bytes);
  std::string error;
  const std::string path = "card_image.bin";
  CHECK(card.save(path, error));
  BlockDevice other;
  CHECK(other.load(path, error));
  CHECK(other.bytes() == card.bytes());
  CHECK(error.empty());
  std::FILE* file = std::fopen(path.c_str(), "ab");
  std::fputc(1, file);
  std::fclose(file);
  CHECK(!other.load(path, error));
  CHECK(error.find("512") != std::string::npos);
  CHECK(other.bytes() == card.bytes());
  std::remove(path.c_str());
  CHECK(!other.load("no/such/file", error));
  CHECK(!card.save("no/such/file", error));
  CHECK(error.find("no/such/file") != std::string::npos);
}

TEST_CASE(a_slow_card_stalls_now_and_then_or_at_each_block) {
  const uint8_t block[BlockDevice::kBlockBytes] = {};
  for (const uint64_t every_us : {0u, 100000u}) {
    BlockDevice card;
    CHECK(card.preallocate(5000) == CardResult::kOk);
    card.set_stalls(40000, every_us);
    uint64_t written = 0, stalled = 0;
    for (uint64_t t_us = 0; t_us < 4000000; t_us += 1000) {
      if (card.busy(t_us)) continue;
      CHECK(card.write(t_us, static_cast<uint32_t>(written++), block) == CardResult::kOk);
      stalled += card.busy(t_us + 30000);
    }
    CHECK(every_us == 0 ? stalled == written : stalled > 20 && stalled < 40);
    card.set_stalls(0, 0);
    CHECK(card.write(5000000, 0, block) == CardResult::kOk);
    CHECK(!card.busy(5001000));
  }
}

TEST_CASE(no_recording_follows_the_last_number) {
  BlockDevice card(instant(0));
  card.put_file(9998, std::vector<uint8_t>(BlockDevice::kBlockBytes));
  CHECK(card.preallocate(1) == CardResult::kOk);
  CHECK(card.preallocate(1) == CardResult::kOutOfRange);
  CHECK(card.next_file(9999) == 9999);
  CHECK(card.next_file(10000) == 0);
}

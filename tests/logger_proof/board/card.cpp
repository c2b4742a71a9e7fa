#include "card.h"

#include <string.h>

namespace proof {

namespace {

constexpr uint32_t kTransferUs = 30;
constexpr uint32_t kProgramUs = 40;
constexpr uint32_t kMetadataUs = 3000;
constexpr uint32_t kPreparedBlocks = 128;

}  // namespace

Card::Card(Medium& medium, const Scenario& scenario, Clock& clock, Truth& truth)
    : medium_(medium),
      scenario_(scenario),
      clock_(clock),
      truth_(truth),
      timing_(scenario.seed, 3),
      fate_(scenario.seed, 4) {}

ErrorCode Card::open(uint32_t n_blocks) {
  clock_.pass(timing_.between(5000, 20000));
  if (!usable()) return ErrorCode::kNoCard;
  const uint32_t first = files() == 0 ? 0 : file().first_block + file().blocks;
  if (files() == kFiles || n_blocks > kMediumBlocks - first) return ErrorCode::kCardFull;
  ++truth_.head.file_count;
  file() = FileTruth{first, n_blocks, 0};
  medium_.blocks = first + n_blocks;
  if (!scenario_.holds_older) memset(at(first), 0, n_blocks * kBlockBytes);
  prepared_ = 0;
  return ErrorCode::kNone;
}

// A piece is half of a step of the driver's; the medium had its zeros at open().
ErrorCode Card::prepare() {
  clock_.pass(timing_.between(1000, 30000));
  if (!usable()) return ErrorCode::kCardWriteFailed;
  const uint32_t left = file().blocks - prepared_;
  prepared_ += left < kPreparedBlocks ? left : kPreparedBlocks;
  return ErrorCode::kNone;
}

bool Card::busy(uint64_t) {
  if (lost_ || !present_) return scenario_.busy_when_gone;
  return clock_.now_us() < busy_until_us_;
}

ErrorCode Card::recover(uint64_t) {
  clock_.pass(timing_.between(2000, 20000));
  if (!present_ || clock_.dead()) return ErrorCode::kNoCard;
  lost_ = false;
  busy_until_us_ = 0;
  return ErrorCode::kNone;
}

// Either the driver says that the card is busy, or it waits inside write().
void Card::stall() {
  const uint64_t took_us = timing_.between(50000, 500001);
  TroubleTruth& trouble = truth_.troubles.add();
  trouble.from_us = clock_.now_us();
  trouble.to_us = clock_.now_us() + took_us;
  if (scenario_.waits_inside) {
    clock_.pass(took_us);
  } else {
    busy_until_us_ = trouble.to_us;
  }
}

ErrorCode Card::write(uint32_t index, const uint8_t* block) {
  clock_.pass(kTransferUs);
  if (!usable()) return ErrorCode::kCardWriteFailed;
  if (index >= prepared_) return ErrorCode::kCardFull;
  busy_until_us_ = clock_.now_us() + timing_.between(50, 400);
  if (scenario_.stall_one_in != 0 && timing_.one_in(scenario_.stall_one_in)) stall();
  if (!usable()) return ErrorCode::kCardWriteFailed;
  remember(file().first_block + index, block);
  return ErrorCode::kNone;
}

void Card::remember(uint32_t position, const uint8_t* block) {
  tfsat::protocol::BlockHeader head;
  head.decode(block, tfsat::protocol::BlockHeader::kSize);
  WriteTruth& write = truth_.writes.add();
  write.t_us = clock_.now_us();
  write.position = position;
  write.file = static_cast<uint8_t>(files());
  write.session = head.session;
  write.number = head.block_number;
  write.first_sample = head.first_sample;
  write.kind = static_cast<uint8_t>(head.kind);
  write.samples = head.sample_count;
  Cached& cached = cache_[cached_++];
  cached.position = position;
  cached.record = truth_.writes.count - 1;
  memcpy(cached.bytes, block, kBlockBytes);
  if (cached_ <= scenario_.cache_blocks) return;
  program(scenario_.fate == Fate::kMixed ? fate_.next() % cached_ : 0);
}

void Card::program(uint32_t slot) {
  const Cached& cached = cache_[slot];
  memcpy(at(cached.position), cached.bytes, kBlockBytes);
  owner_[cached.position] = cached.record + 1;
  forget(slot);
}

void Card::forget(uint32_t slot) {
  --cached_;
  memmove(cache_ + slot, cache_ + slot + 1, (cached_ - slot) * sizeof cache_[0]);
}

ErrorCode Card::sync() {
  while (usable() && cached_ > 0) {
    clock_.pass(kProgramUs);
    if (usable() && cached_ > 0) program(0);
  }
  clock_.pass(timing_.between(200, 2000));
  if (!usable()) return ErrorCode::kCardWriteFailed;
  for (; first_unsynced_ < truth_.writes.count; ++first_unsynced_) {
    truth_.writes.items[first_unsynced_].synced = 1;
  }
  return ErrorCode::kNone;
}

ErrorCode Card::close(uint32_t n_blocks) {
  clock_.closing();
  const ErrorCode error = sync();
  if (error != ErrorCode::kNone) return error;
  clock_.pass(kMetadataUs);
  if (!usable()) return ErrorCode::kCardWriteFailed;
  file().blocks = n_blocks;
  medium_.blocks = file().first_block + n_blocks;
  clock_.pass(kMetadataUs);
  file().closed = usable();
  return closed() ? ErrorCode::kNone : ErrorCode::kCardWriteFailed;
}

void Card::lose_supply() {
  uint32_t torn = scenario_.fate == Fate::kTorn && cached_ > 0 ? 1 : 0;
  if (scenario_.fate == Fate::kMixed && fate_.one_in(2)) torn = 1;
  while (cached_ > 0) {
    const uint32_t slot = fate_.next() % cached_;
    if (torn > 0) {
      --torn;
      tear(cache_[slot]);
      forget(slot);
    } else if (scenario_.fate == Fate::kMixed && fate_.one_in(2)) {
      program(slot);
    } else {
      forget(slot);
    }
  }
  first_unsynced_ = truth_.writes.count;  // no later sync speaks for what is lost
}

// Of the new block some bytes: the first, the last, every other stretch, or the first and then
// noise.
void Card::tear(const Cached& cached) {
  uint8_t* medium = at(cached.position);
  uint8_t before[kBlockBytes];
  memcpy(before, medium, kBlockBytes);
  const uint32_t form = fate_.next() % 4;
  const uint32_t split = fate_.between(1, kBlockBytes);
  const uint32_t stretch = 8u << fate_.next() % 6;
  for (uint32_t i = 0; i < kBlockBytes; ++i) {
    const uint8_t fresh = cached.bytes[i];
    switch (form) {
      case 0: medium[i] = i < split ? fresh : medium[i]; break;
      case 1: medium[i] = i < split ? medium[i] : fresh; break;
      case 2: medium[i] = i / stretch % 2 == 0 ? fresh : medium[i]; break;
      default: medium[i] = i < split ? fresh : static_cast<uint8_t>(fate_.next()); break;
    }
  }
  if (memcmp(medium, cached.bytes, kBlockBytes) == 0) {
    owner_[cached.position] = cached.record + 1;
  } else if (memcmp(medium, before, kBlockBytes) != 0) {
    owner_[cached.position] = 0;
  }
}

uint32_t Card::spoil() {
  static uint8_t copies[kMediumBlocks];
  memset(copies, 0, sizeof copies);
  for (uint32_t i = 0; i < medium_.blocks; ++i) {
    if (owner_[i] != 0) ++copies[truth_.writes.items[owner_[i] - 1].number % kMediumBlocks];
  }
  uint32_t spoiled = 0;
  for (uint32_t i = 0; i < medium_.blocks; ++i) {
    if (owner_[i] == 0) continue;
    uint8_t& left = copies[truth_.writes.items[owner_[i] - 1].number % kMediumBlocks];
    if (i != 0 && (left < 2 || !fate_.one_in(20))) continue;
    --left;
    owner_[i] = 0;
    ++spoiled;
    at(i)[fate_.next() % kBlockBytes] ^= static_cast<uint8_t>(1u << fate_.next() % 8);
  }
  return spoiled;
}

void Card::settle_truth() {
  for (uint32_t i = 0; i < medium_.blocks; ++i) {
    if (owner_[i] != 0) truth_.writes.items[owner_[i] - 1].on_medium = 1;
  }
}

}  // namespace proof

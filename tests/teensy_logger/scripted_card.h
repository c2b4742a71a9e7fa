// The emulated card with a script: when it has no contact, which calls fail; and a count of what was asked of it.
#pragma once

#include <cstring>
#include <iterator>
#include <set>
#include <vector>

#include "../../firmware/teensy_logger/src/core/block_layout.h"
#include "boards/logger_card_port.h"

namespace tfsat_test {

using tfsat::logger::Block;
using tfsat::protocol::ErrorCode;

// It takes everything at once unless a test sets `device`'s times, and keeps it in its cache until the next sync.
class ScriptedCard final : public tfsat::logger::BlockSink, public tfsat::logger::LogArchive {
 public:
  ErrorCode open(uint32_t n_blocks) override {
    ++opens;
    move_to(t_us);
    return open_error != ErrorCode::kNone ? open_error : port.open(n_blocks);
  }
  bool busy(uint64_t now_us) override {
    move_to(now_us);
    return port.busy(now_us);
  }
  ErrorCode prepare() override {
    return prepare_error != ErrorCode::kNone ? prepare_error : port.prepare();
  }
  uint32_t prepared_blocks() override { return port.prepared_blocks(); }
  ErrorCode recover(uint64_t now_us) override {
    ++recoveries;
    move_to(now_us);
    return port.recover(now_us);
  }
  ErrorCode write(uint32_t index, const uint8_t* block) override {
    if (port.busy(t_us)) ++writes_while_busy;
    if (index >= port.prepared_blocks()) ++writes_unprepared;
    if (failures_left > 0) {
      --failures_left;
      return ErrorCode::kCardWriteFailed;
    }
    const ErrorCode error = port.write(index, block);
    if (error == ErrorCode::kNone) ++writes;
    return error;
  }
  ErrorCode sync() override {
    const ErrorCode error = port.sync();
    if (error == ErrorCode::kNone) sync_times_us.push_back(t_us);
    return error;
  }
  ErrorCode close(uint32_t n_blocks) override {
    const ErrorCode error = port.close(n_blocks);
    if (error == ErrorCode::kNone) ++closes;
    return error;
  }
  ErrorCode inspect(uint32_t n_blocks) override {
    ++looks;
    return open_error != ErrorCode::kNone ? open_error : port.inspect(n_blocks);
  }
  uint32_t free_mib() override { return port.free_mib(); }

  bool find(uint16_t from, uint16_t& number, uint32_t& n_blocks) override {
    return port.find(from, number, n_blocks);
  }
  ErrorCode read(uint16_t number, uint32_t index, uint8_t* block) override {
    return unreadable.count(index) != 0 ? ErrorCode::kCardWriteFailed : port.read(number, index, block);
  }
  ErrorCode erase(uint16_t number) override { return port.erase(number); }

  void put_file(uint16_t number, const std::vector<Block>& blocks) {
    std::vector<uint8_t> bytes;
    for (const Block& block : blocks) bytes.insert(bytes.end(), std::begin(block.bytes), std::end(block.bytes));
    device.put_file(number, bytes);
  }
  // Of the newest file.
  std::vector<Block> blocks() const {
    const std::vector<uint8_t> bytes = device.bytes();
    std::vector<Block> all(bytes.size() / sizeof(Block::bytes));
    for (size_t i = 0; i < all.size(); ++i) {
      std::memcpy(all[i].bytes, bytes.data() + i * sizeof all[i].bytes, sizeof all[i].bytes);
    }
    return all;
  }

  tfsat::emulator::BlockDevice device{{0, 0, UINT32_MAX}};
  tfsat::emulator::CardPort port{device};
  std::vector<uint64_t> sync_times_us;
  ErrorCode open_error = ErrorCode::kNone;
  ErrorCode prepare_error = ErrorCode::kNone;
  std::set<uint32_t> unreadable;  // blocks
  uint64_t t_us = 0;
  uint64_t gone_until_us = 0;  // no contact: what was written since the last sync is lost
  int failures_left = 0;
  int recoveries = 0, looks = 0, opens = 0, closes = 0, writes = 0, writes_while_busy = 0;
  int writes_unprepared = 0;

 private:
  void move_to(uint64_t now_us) {
    t_us = now_us;
    device.set_present(t_us >= gone_until_us);
  }
};

}  // namespace tfsat_test

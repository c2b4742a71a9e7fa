// The core's ports for unit tests: they do what the test says and complain when they are misused.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <functional>
#include <utility>
#include <vector>

#include "../../firmware/arduino_sequencer/src/core/maneuver.h"
#include "../../firmware/arduino_sequencer/src/core/ports.h"
#include "../../firmware/arduino_sequencer/src/protocol/link.h"
#include "check.h"

namespace tfsat_test {

using tfsat::sequencer::SwitchEdge;
using tfsat::sequencer::tick_t;

inline bool same(const tfsat::sequencer::Maneuver& a, const tfsat::sequencer::Maneuver& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

class FakeSwitches : public tfsat::sequencer::ReleaseSwitches {
 public:
  bool take_edge(SwitchEdge& edge) override {
    if (edges.empty()) return false;
    edge = edges.front();
    edges.pop_front();
    return true;
  }
  uint8_t levels() override {
    const uint8_t read = open;
    const std::function<void()> happens = std::move(after_levels);
    after_levels = nullptr;
    if (happens) happens();
    return read;
  }

  // With `stamped` false the hardware missed the edge: only the level tells.
  void set(uint8_t index, bool opened, tick_t at, bool stamped = true) {
    const uint8_t bit = static_cast<uint8_t>(1 << index);
    if (((open & bit) != 0) == opened) return;
    open = static_cast<uint8_t>(opened ? open | bit : open & ~bit);
    if (stamped) edges.push_back(SwitchEdge{at, index, opened});
  }

  std::deque<SwitchEdge> edges;
  std::function<void()> after_levels;  // happens once, as soon as the levels have been read
  uint8_t open = 0;
};

class FakeServos : public tfsat::sequencer::ServoOutput {
 public:
  struct Change {
    uint8_t joint;
    tick_t at;
    uint16_t width_ticks;
  };

  void hold(uint8_t joint, uint16_t width_ticks, uint32_t frame_ticks) override {
    CHECK(joint < 3 && width_ticks >= 1000 && width_ticks <= 5000);
    CHECK(frame_ticks >= 10000 && frame_ticks <= 40000);
    widths[joint] = width_ticks;
    frames[joint] = frame_ticks;
    held = true;
    changes.clear();
    begun = 0;
    cancelled = false;
  }
  void schedule(uint8_t joint, tick_t at, uint16_t width_ticks) override {
    CHECK(joint < 3 && width_ticks >= 1000 && width_ticks <= 5000);
    changes.push_back(Change{joint, at, width_ticks});
  }
  bool cancel() override {
    cancelled = true;
    return under_way;
  }
  void stop() override {
    held = false;
    begun = 0;
  }
  uint16_t changes_begun() override { return begun; }
  // Begun when it was asked for, and a tick late.
  tick_t change_began_at(uint8_t index) override { return changes.at(index).at + 1; }

  std::vector<Change> changes;
  uint16_t widths[3] = {0, 0, 0};
  uint32_t frames[3] = {0, 0, 0};
  uint16_t begun = 0;  // bit i: change i
  bool held = false;
  bool cancelled = false;
  bool under_way = false;  // a pulse of a new width
};

class FakeHealth : public tfsat::sequencer::Health {
 public:
  uint16_t ram_never_used_bytes() override { return 777; }
};

// An EEPROM whose power can go at any write, whose cells can be worn out, and which takes as many
// polls as it likes.
class FakeMemory : public tfsat::sequencer::NonVolatile {
 public:
  explicit FakeMemory(uint8_t fill = 0xFF) : bytes(1024, fill) {}

  uint8_t read(uint16_t address) override {
    CHECK(busy_polls == 0);
    return bytes.at(address);
  }
  bool busy() override {
    if (busy_polls > 0) --busy_polls;
    return busy_polls > 0;
  }
  void write(uint16_t address, uint8_t value) override {
    CHECK(busy_polls == 0);
    CHECK(bytes.at(address) != value);  // wear
    busy_polls = 3;
    ++writes;
    if (address == worn_address) return;
    if (writes == cut_at_write) {
      bytes.at(address) = torn(bytes.at(address), value);
      dead = true;
    }
    if (!dead) bytes.at(address) = value;
  }

  // What a write leaves that the power did not outlast.
  uint8_t torn(uint8_t old_value, uint8_t value) const {
    switch (tear) {
      case 0: return old_value;
      case 1: return value;
      case 2: return 0xFF;
      case 3: return static_cast<uint8_t>(old_value & value);
      case 4: return static_cast<uint8_t>(old_value | value);
      default: return static_cast<uint8_t>(std::rand());
    }
  }

  std::vector<uint8_t> bytes;
  int busy_polls = 0;
  int writes = 0;
  int cut_at_write = 0;
  int tear = 0;
  int worn_address = -1;
  bool dead = false;
};

// A host that takes and gives as many bytes at a time as the test says.
class FakeStream : public tfsat::protocol::ByteStream {
 public:
  bool connected() override { return plugged; }
  int read() override {
    CHECK(plugged);
    if (to_board.empty()) return -1;
    const uint8_t byte = to_board.front();
    to_board.pop_front();
    return byte;
  }
  size_t write(const uint8_t* data, size_t size) override {
    CHECK(plugged && size > 0);
    const size_t taken = size < room ? size : room;
    from_board.insert(from_board.end(), data, data + taken);
    return taken;
  }

  std::deque<uint8_t> to_board;
  std::vector<uint8_t> from_board;
  size_t room = 1000;
  bool plugged = true;
};

}  // namespace tfsat_test

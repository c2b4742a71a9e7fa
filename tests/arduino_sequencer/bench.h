// A whole core on ports that do what the test says and complain when they are misused, with a link to it, and time
// that the test lets pass.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <functional>
#include <random>
#include <utility>
#include <vector>

#include "../../firmware/arduino_sequencer/src/core/request_server.h"
#include "../../firmware/arduino_sequencer/src/core/sequencer.h"
#include "check.h"

namespace tfsat_test {

using tfsat::protocol::ErrorCode;
using tfsat::protocol::ResetCause;
using tfsat::protocol::SequencerState;
using tfsat::sequencer::kTicksPerMs;
using tfsat::sequencer::Maneuver;
using tfsat::sequencer::Sequencer;
using tfsat::sequencer::Settings;
using tfsat::sequencer::Stored;
using tfsat::sequencer::Stroke;
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

inline std::vector<uint8_t> bytes_of(const Settings& record) {
  std::vector<uint8_t> bytes(Settings::kSize);
  record.encode(bytes.data());
  return bytes;
}

inline std::vector<uint8_t> bytes_of(const Maneuver& record) {
  std::vector<uint8_t> bytes(Maneuver::kSize);
  std::memcpy(bytes.data(), &record, bytes.size());
  return bytes;
}

template <typename Record>
bool same_record(const Record& a, const Record& b) {
  return bytes_of(a) == bytes_of(b);
}

// As an upload does: the record, then its commit.
template <typename Record>
void stage(Stored<Record>& store, const Record& wanted) {
  const std::vector<uint8_t> bytes = bytes_of(wanted);
  std::memcpy(store.staged(), bytes.data(), bytes.size());
  store.commit();
}

// Polls until the store rests or the power goes; false if it never does.
template <typename Record>
bool finish(Stored<Record>& store, const FakeMemory& memory = FakeMemory()) {
  for (int polls = 0; polls < 2000 && store.writing() && !memory.dead; ++polls) store.poll();
  return !store.writing();
}

// As a host does it: repeats its commit until there is nothing left to write. False if it failed.
template <typename Record>
bool put(FakeMemory& memory, uint16_t address, const Record& wanted) {
  memory.busy_polls = 0;
  Stored<Record> store(memory, address);
  store.load();
  store.begin();
  stage(store, wanted);
  do {
    if (!finish(store, memory) || store.failed()) return false;
    store.commit();
  } while (store.changed());
  return store.defect() == ErrorCode::kNone && same_record(store.current(), wanted);
}

// One into which a maneuver has been uploaded, so that the board arms.
inline std::vector<uint8_t> uploaded_eeprom(const Maneuver& maneuver = Maneuver::factory()) {
  FakeMemory memory;
  CHECK(put(memory, Sequencer::kManeuverAddress, maneuver));
  return memory.bytes;
}

struct Bench {
  FakeSwitches switches;
  FakeServos servos;
  FakeMemory memory;
  FakeStream stream;
  tfsat::sequencer::RetainedState retained;
  FakeHealth health;
  tfsat::sequencer::Sequencer core{switches, servos, memory, retained};
  tfsat::sequencer::Identity identity{{1, 2, 3, 4, 5, 6, 7, 8}, 0x12345678, ResetCause::kPowerOn, 0};
  tfsat::sequencer::RequestServer server{core, identity, health};
  tfsat::protocol::Link link{stream, server};
  tick_t now;

  explicit Bench(tick_t start = 0, const std::vector<uint8_t>& eeprom = uploaded_eeprom())
      : now(start) {
    memory.bytes = eeprom;
    retained.begun.set(0);
    retained.clear();
    core.start(now, ResetCause::kPowerOn);
  }

  // The board of before, after a reset: EEPROM, retained RAM and switches are the same.
  Bench(const Bench& before, ResetCause cause)
      : retained(before.retained), now(before.now + kTicksPerMs) {
    memory.bytes = before.memory.bytes;
    switches.open = before.switches.open;
    core.start(now, cause);
  }

  void poll() {
    core.poll(now);
    server.update(now, link.rejected_frames());
    link.poll();
  }
  // Loops of 0.1 ms.
  void run_ms(uint32_t ms) {
    for (uint32_t i = 0; i < 10 * ms; ++i) {
      now += kTicksPerMs / 10;
      poll();
    }
  }
  // Loops of a second.
  void run_hours(uint32_t hours) {
    for (uint32_t i = 0; i < 3600 * hours; ++i) {
      now += 1000 * kTicksPerMs;
      poll();
    }
  }
  void send(uint8_t type, std::vector<uint8_t> payload = {}) {
    using namespace tfsat::protocol;
    uint8_t frame[encoded_frame_bytes(kMaxPayloadBytes)];
    const size_t size = encode_frame(type, 1, payload.data(), payload.size(), frame);
    stream.to_board.insert(stream.to_board.end(), frame, frame + size);
  }
  // All of an upload but its commits.
  void send_strokes(const Maneuver& maneuver) {
    using namespace tfsat::protocol;
    const uint16_t speed = maneuver.speed_cdeg_s;
    send(ManeuverBeginRequest::kType, {maneuver.stroke_count, static_cast<uint8_t>(speed),
                                       static_cast<uint8_t>(speed >> 8)});
    for (uint8_t i = 0; i < maneuver.stroke_count; ++i) {
      std::vector<uint8_t> stroke = {i};
      const uint8_t* bytes = reinterpret_cast<const uint8_t*>(&maneuver.strokes[i]);
      stroke.insert(stroke.end(), bytes, bytes + sizeof(Stroke));
      send(ManeuverStrokeRequest::kType, stroke);
    }
  }
  void send_commit(const Maneuver& maneuver) {
    const uint16_t crc = maneuver.crc();
    send(tfsat::protocol::ManeuverCommitRequest::kType,
         {static_cast<uint8_t>(crc), static_cast<uint8_t>(crc >> 8)});
  }
  // As the servo driver's interrupts do it, whether or not the main loop still comes round: bit i is
  // stroke i.
  void strokes_begin(uint16_t strokes) {
    servos.begun = strokes;
    retained.begun.set(strokes);
  }
  void first_strokes_begin(uint8_t count) { strokes_begin(static_cast<uint16_t>((1u << count) - 1)); }
  ErrorCode arm() { return core.arm(core.arm_token(), now); }
  void wait_armed() {
    CHECK(arm() == ErrorCode::kNone);
    run_ms(20);
  }
  // Armed and released; the release.
  tick_t fly(uint32_t ms = 10) {
    wait_armed();
    return release(ms);
  }
  tick_t release(uint32_t ms = 10) {
    open_both();
    const tick_t released_at = now;
    run_ms(ms);
    CHECK(core.state() == SequencerState::kRunning);
    return released_at;
  }
  bool is(SequencerState state, ErrorCode fault = ErrorCode::kNone) const {
    return core.state() == state && core.fault() == fault;
  }
  bool limp() const { return is(SequencerState::kSafe) && !servos.held; }
  void open_both() {
    switches.set(0, true, now);
    switches.set(1, true, now);
  }
  void close_both() {
    switches.set(0, false, now);
    switches.set(1, false, now);
  }
};

// A switch changes.
struct Contact {
  tick_t at;
  uint8_t index;
  bool open;
};

using Random = std::mt19937;

inline tick_t draw(Random& random, tick_t least, tick_t most) {
  return std::uniform_int_distribution<tick_t>(least, most)(random);
}

struct Answers {
  std::vector<uint8_t> types;
  std::vector<std::vector<uint8_t>> payloads;
  explicit Answers(const std::vector<uint8_t>& bytes) {
    tfsat::protocol::FrameReceiver<tfsat::protocol::kMaxPayloadBytes> receiver;
    for (const uint8_t byte : bytes) {
      if (!receiver.feed(byte)) continue;
      types.push_back(receiver.type());
      payloads.emplace_back(receiver.payload(), receiver.payload() + receiver.payload_bytes());
    }
    CHECK(receiver.rejected() == 0);
  }
};

}  // namespace tfsat_test

// A whole core on fake ports, with a link to it, and time that the test lets pass.
#pragma once

#include "../../firmware/arduino_sequencer/src/core/request_server.h"
#include "../../firmware/arduino_sequencer/src/core/sequencer.h"
#include "fake_ports.h"

namespace tfsat_test {

using tfsat::protocol::ErrorCode;
using tfsat::protocol::ResetCause;
using tfsat::sequencer::kTicksPerMs;
using tfsat::sequencer::Maneuver;
using tfsat::sequencer::Sequencer;
using tfsat::sequencer::Settings;
using tfsat::sequencer::Stored;
using tfsat::sequencer::Stroke;

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

// Stores until it rests or the power goes; false if it failed.
template <typename Record>
bool put(FakeMemory& memory, uint16_t address, const Record& wanted) {
  memory.busy_polls = 0;
  Stored<Record> store(memory, address);
  store.load();
  const std::vector<uint8_t> bytes = bytes_of(wanted);
  std::memcpy(store.staged(), bytes.data(), bytes.size());
  store.commit();
  for (int polls = 0; polls < 2000 && store.writing() && !memory.dead; ++polls) store.poll();
  return !store.writing() && !store.failed() && same_record(store.current(), wanted);
}

// An EEPROM that was never written.
inline std::vector<uint8_t> erased_eeprom() { return FakeMemory().bytes; }

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
  void open_both() {
    switches.set(0, true, now);
    switches.set(1, true, now);
  }
  void close_both() {
    switches.set(0, false, now);
    switches.set(1, false, now);
  }
};

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

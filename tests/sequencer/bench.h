// A whole core on fake ports, with a link to it, and time that the test lets pass.
#pragma once

#include "../../firmware/arduino_sequencer/src/core/request_server.h"
#include "../../firmware/arduino_sequencer/src/core/sequencer.h"
#include "fake_ports.h"

namespace tfsat_test {

using tfsat::protocol::ErrorCode;
using tfsat::protocol::ResetCause;
using tfsat::sequencer::kTicksPerMs;

struct Bench {
  FakeSwitches switches;
  FakeServos servos;
  FakeMemory memory;
  FakeStream stream;
  tfsat::sequencer::RetainedState retained;
  FakeHealth health;
  tfsat::sequencer::Sequencer core{switches, servos, memory, retained};
  tfsat::sequencer::Identity identity{{1, 2, 3, 4, 5, 6, 7, 8}, 0x12345678, ResetCause::kPowerOn};
  tfsat::sequencer::RequestServer server{core, identity, health};
  tfsat::protocol::Link link{stream, server};
  tick_t now;

  explicit Bench(tick_t start = 0) : now(start) {
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
  // As the servo driver's interrupts do it, whether or not the main loop still comes round.
  void strokes_begin(uint8_t count) {
    servos.begun = count;
    retained.begun.set(count);
  }
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

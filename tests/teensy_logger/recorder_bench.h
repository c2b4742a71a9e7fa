// A recorder with its card in virtual time: the interrupt as Logger::sample() has it, then passes of
// the main loop; and the drop of a robot.
#pragma once

#include <vector>

#include "../../firmware/teensy_logger/src/core/recorder.h"
#include "check.h"
#include "recording.h"
#include "scripted_card.h"

namespace tfsat_test {

using tfsat::logger::Edge;
using tfsat::logger::EventQueue;
using tfsat::logger::kRingBlocks;
using tfsat::logger::Recorder;
using tfsat::protocol::DropPhase;
using tfsat::protocol::Event;
using tfsat::protocol::EventCode;
using tfsat::protocol::LoggerState;
using tfsat::protocol::StopReason;

struct RecorderBench {
  static constexpr uint32_t kFileBlocks = 16384;
  static constexpr uint32_t kPeriodUs = 3571;
  static constexpr uint64_t kFallenUs = 2500000;
  static constexpr uint32_t kShockCounts = 20000;  // 9.8 g

  explicit RecorderBench(uint32_t with_period_us = kPeriodUs, uint32_t ring_blocks = kRingBlocks)
      : memory(ring_blocks), recorder(memory.data(), ring_blocks, card), period_us(with_period_us) {}

  ErrorCode start(uint32_t number, uint32_t session, uint32_t file_blocks = kFileBlocks) {
    Recorder::Plan plan = {};
    plan.session = session;
    plan.header.who_am_i[0] = 0x68;
    plan.header.rate_hz = 1e6f / static_cast<float>(period_us);
    plan.header.accel_lsb_per_g = 2048.0f;
    plan.file_blocks = file_blocks;
    plan.after_landing_s = after_landing_s;
    return recorder.start(number, plan);
  }

  // One sampling period: the interrupt, then some passes of the main loop.
  void interrupt() {
    t_us += period_us;
    Event event;
    if (recorder.capturing()) recorder.watch().poll(t_us, open, peak_counts);
    while (!events.full() && recorder.take_event(event)) events.push(event);
    tfsat::protocol::Sample sample = {};
    sample.angle[0] = static_cast<uint16_t>(recorder.samples());
    recorder.capture(t_us, sample, events);
  }
  void tick() {
    interrupt();
    for (uint32_t pass = 0; pass < 4; ++pass) recorder.poll(t_us + pass * period_us / 5);
  }
  void run_us(uint64_t duration_us) {
    for (const uint64_t end_us = t_us + duration_us; t_us < end_us;) tick();
  }
  void run_to(uint64_t end_us) {
    if (end_us > t_us) run_us(end_us - t_us);
  }
  Recording stop_and_read() {
    CHECK(recorder.stop() == ErrorCode::kNone);
    return wait_and_read();
  }
  Recording wait_and_read() {
    for (int i = 0; i < 20000 && recorder.uses_card(); ++i) tick();
    CHECK(recorder.state() == LoggerState::kStopped);
    const std::vector<Block> blocks = card.blocks();
    return read_recording(blocks, blocks.size());
  }

  void set_switches(uint8_t now_open) {
    for (uint8_t i = 0; i < 2; ++i) {
      const bool opens = now_open >> i & 1;
      if (opens == (open >> i & 1)) continue;
      recorder.watch().on_edge(Edge{t_us, Edge::Source::kSwitch, i, opens, 0});
    }
    open = now_open;
  }
  // Lift, then the release; the time of it.
  uint64_t release_after_us(uint64_t lift_us) {
    run_us(lift_us);
    set_switches(3);
    return t_us;
  }
  void land() {
    peak_counts = kShockCounts;
    tick();
    peak_counts = 2048;
  }
  // Lift, release, fall, landing, and some time more; the release's time.
  uint64_t drop(uint64_t lift_us, uint64_t then_us) {
    const uint64_t released_us = release_after_us(lift_us);
    run_us(kFallenUs);
    land();
    run_us(then_us);
    return released_us;
  }
  // Every sample was taken, and is in the recording.
  bool kept_all(const Recording& recording) const {
    return recording.samples.size() == recorder.samples() && recorder.samples_dropped() == 0;
  }
  // What RAM holds, as the log server hands it on.
  std::vector<Block> ram() const {
    std::vector<Block> blocks(recorder.ram_blocks());
    for (uint32_t i = 0; i < blocks.size(); ++i) CHECK(recorder.copy_from_ram(i, blocks[i]));
    return blocks;
  }

  std::vector<Block> memory;
  ScriptedCard card;
  Recorder recorder;
  EventQueue events;
  uint64_t t_us = 1000000;
  uint32_t period_us;
  uint32_t peak_counts = 2048;
  uint16_t after_landing_s = 30;
  uint8_t open = 0;
};

}  // namespace tfsat_test

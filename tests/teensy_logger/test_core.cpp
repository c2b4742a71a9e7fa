// The logger between its two contexts, instant by instant: what one recording must not leave to the
// next, events that must find room, a timer and a memory that do as they are told or do not.
#include <deque>
#include <initializer_list>

#include "../../firmware/teensy_logger/src/core/logger.h"
#include "recording.h"
#include "scripted_card.h"
#include "check.h"
#include "fake_ports.h"

using namespace tfsat::logger;
using namespace tfsat::protocol;
using tfsat_test::events_of;
using tfsat_test::Recording;

namespace {

struct Bus final : I2cBus {  // nobody answers
  void set_clock(uint16_t) override {}
  void start_read(uint8_t, uint8_t, uint8_t*, uint8_t) override {}
  void start_write(uint8_t, uint8_t, uint8_t) override {}
  I2cResult poll() override { return result; }
  void recover() override {}
  I2cResult result = I2cResult::kNack;
};

struct Angles final : Adc {
  uint8_t read(uint16_t*) override { return 0; }
};

struct Pins final : Inputs {
  bool take_edge(Edge& edge) override {
    if (edges.empty()) return false;
    edge = edges.front();
    edges.pop_front();
    return true;
  }
  uint8_t switches_open() override { return open; }
  std::deque<Edge> edges;
  uint8_t open = 0;
};

struct Timer final : SampleTimer {
  void start(uint16_t rate) override {
    CHECK(!running);
    running = true;
    rate_hz = rate;
    ++starts;
  }
  void stop() override { running = false; }
  bool running = false;
  uint16_t rate_hz = 0;
  int starts = 0;
};

struct Counter final : Entropy {
  uint32_t next() override { return n++; }
  uint32_t n = 5;
};

struct Bench {
  Bench() : memory_blocks(kRingBlocks) { core.begin(); }

  void interrupt() {
    t_us += 1000000 / timer.rate_hz;
    core.sample(t_us);
  }
  void loop() {
    for (uint32_t i = 0; i < 4; ++i) core.poll(t_us + 10 * i);
  }
  void run_ms(uint32_t ms) {
    for (const uint64_t end_us = t_us + 1000u * ms; t_us < end_us; loop()) interrupt();
  }
  // The reply's payload, or the error's.
  std::vector<uint8_t> exchange(uint8_t type, const uint8_t* payload = nullptr, size_t size = 0) {
    uint8_t frame[encoded_frame_bytes(kMaxPayloadBytes)];
    const size_t n = encode_frame(type, 1, payload, size, frame);
    cable.bytes.clear();
    cable.room = SIZE_MAX;
    cable.to_board.insert(cable.to_board.end(), frame, frame + n);
    loop();
    FrameReceiver<kMaxPayloadBytes> receiver;
    for (const uint8_t byte : cable.bytes) {
      if (receiver.feed(byte)) break;
    }
    return {receiver.payload(), receiver.payload() + receiver.payload_bytes()};
  }
  template <typename Request>
  std::vector<uint8_t> ask(const Request& request) {
    uint8_t payload[Request::kSize];
    request.encode(payload);
    return exchange(Request::kType, payload, sizeof payload);
  }
  template <typename Request>
  ErrorReply refused(const Request& request) {
    const std::vector<uint8_t> payload = ask(request);
    ErrorReply reply = {};
    CHECK(reply.decode(payload.data(), payload.size()));
    return reply;
  }
  LoggerStatusReply status() {
    const std::vector<uint8_t> payload = exchange(LoggerStatusRequest::kType);
    LoggerStatusReply reply = {};
    CHECK(reply.decode(payload.data(), payload.size()));
    return reply;
  }
  void edge(Edge::Source source, uint8_t index, bool opens) {
    pins.edges.push_back(Edge{t_us + 1, source, index, opens, 0});
  }
  Recording stop() {
    exchange(RecordStopRequest::kType);
    run_ms(1000);
    CHECK(core.state() == LoggerState::kStopped);
    const std::vector<tfsat_test::Block> blocks = card.blocks();
    return tfsat_test::read_recording(blocks, blocks.size());
  }

  Bus bus_a, bus_b;
  Angles angles;
  Pins pins;
  Timer timer;
  tfsat_test::ScriptedCard card;
  tfsat_test::FakeMemory memory;
  tfsat_test::FakeStream cable;
  Counter entropy;
  std::vector<Block> memory_blocks;
  Logger core{Ports{bus_a, bus_b, angles, pins, timer, card, card, memory, cable, entropy},
              Identity{}, memory_blocks.data(), kRingBlocks};
  uint64_t t_us = 1000000;
};

LoggerSettings small_file(uint16_t rate_hz) {
  LoggerSettings settings = factory_settings();
  settings.rate_hz = rate_hz;
  settings.file_mib = 8;
  return settings;
}

}  // namespace

TEST_CASE(the_timer_runs_at_the_rate_that_was_set) {
  Bench bench;
  CHECK(bench.timer.running && bench.timer.rate_hz == 280 && bench.timer.starts == 1);
  bench.ask(LoggerSettingsWriteRequest{small_file(1000)});
  CHECK(bench.timer.running && bench.timer.rate_hz == 1000 && bench.timer.starts == 2);
}

TEST_CASE(a_memory_that_does_not_keep_settings_is_told_and_nothing_changes) {
  Bench bench;
  bench.memory.worn_cell = 0;
  const ErrorReply reply = bench.refused(LoggerSettingsWriteRequest{small_file(1000)});
  CHECK(reply.code == ErrorCode::kStoreFailed);
  CHECK(bench.timer.rate_hz == 280 && bench.timer.starts == 1);
  CHECK(bench.status().rate_hz == 280 && bench.status().settings_origin == Origin::kFactory);
}

TEST_CASE(late_ticks_are_logged_and_counted_since_the_start) {
  Bench bench;
  bench.run_ms(100);
  bench.ask(RecordStartRequest{1, 0, 0, 0});
  bench.run_ms(100);
  bench.t_us += 3571;  // a tick without a sample
  bench.run_ms(100);
  const uint32_t interval_us = 2 * 3571;
  const Recording log = bench.stop();
  const std::vector<Event> late = events_of(log, EventCode::kSamplingLate);
  CHECK(late.size() == 1 && late[0].value == static_cast<int>(interval_us));
  CHECK(log.footers.at(0).late_ticks == 1 && log.footers[0].interval_max_us == interval_us);
  CHECK(bench.status().late_ticks == 1);
  bench.ask(LoggerSettingsWriteRequest{small_file(1000)});
  bench.run_ms(100);
  CHECK(bench.status().late_ticks == 1);
  bench.t_us += 5000;
  bench.run_ms(100);
  CHECK(bench.status().late_ticks == 2);
}

// At a low rate a stop, its closing and the next start may all come between two instants.
TEST_CASE(strokes_and_events_of_a_recording_do_not_reach_the_next) {
  Bench bench;
  bench.ask(LoggerSettingsWriteRequest{small_file(10)});
  bench.run_ms(500);
  bench.ask(RecordStartRequest{1, 0, 0, 0});
  bench.run_ms(500);
  for (int i = 0; i < 3; ++i) bench.edge(Edge::Source::kStroke, 0, true);
  bench.run_ms(500);
  bench.exchange(RecordStopRequest::kType);
  bench.interrupt();
  for (int i = 0; i < 20 && bench.core.state() != LoggerState::kStopped; ++i) bench.loop();
  CHECK(bench.core.state() == LoggerState::kStopped);
  bench.ask(RecordStartRequest{2, 0, 0, 0});
  CHECK(bench.core.state() == LoggerState::kRecording);
  bench.edge(Edge::Source::kStroke, 0, true);
  bench.run_ms(500);
  const std::vector<Event> strokes = events_of(bench.stop(), EventCode::kStroke);
  CHECK(strokes.size() == 1 && strokes[0].index == 0);
}

TEST_CASE(a_recording_that_follows_one_in_ram_begins_with_no_events) {
  Bench bench;
  bench.card.open_error = ErrorCode::kNoCard;
  bench.run_ms(100);
  bench.ask(RecordStartRequest{1, 0, 0, 0});
  bench.run_ms(100);
  for (uint8_t i = 0; i < 40; ++i) bench.edge(Edge::Source::kStroke, 0, true);
  bench.interrupt();  // most of them wait for room
  bench.card.open_error = ErrorCode::kNone;
  bench.ask(RecordStartRequest{2, 0, 0, 0});
  CHECK(bench.core.state() == LoggerState::kRecording);
  bench.run_ms(500);
  CHECK(events_of(bench.stop(), EventCode::kStroke).empty());
}

TEST_CASE(a_chattering_switch_takes_no_room_from_what_the_logger_has_to_tell) {
  Bench bench;
  bench.run_ms(100);
  bench.ask(RecordStartRequest{1, 0, 0, 0});
  bench.run_ms(100);
  for (uint8_t i = 0; i < 200; ++i) bench.edge(Edge::Source::kSwitch, 0, i % 2 == 0);
  bench.interrupt();
  bench.bus_a.result = I2cResult::kStuck;  // the cause becomes another
  bench.bus_b.result = I2cResult::kStuck;
  bench.t_us += 10000;
  bench.run_ms(2000);
  const Recording log = bench.stop();
  CHECK(events_of(log, EventCode::kSwitchEdge).size() == 200);
  CHECK(events_of(log, EventCode::kSamplingLate).size() == 1);
  CHECK(events_of(log, EventCode::kSensorFault).size() == 4);
  CHECK(log.samples.size() == log.footers.at(0).samples);
}

// Looking may take a second, which RAM cannot wait for.
TEST_CASE(nobody_looks_at_the_card_while_only_ram_has_the_fall) {
  Bench bench;
  bench.card.open_error = ErrorCode::kNoCard;
  bench.run_ms(5000);
  CHECK(bench.card.looks == 3);
  bench.ask(RecordStartRequest{1, 0, 0, 0});
  bench.run_ms(5000);
  const int looks = bench.card.looks;
  CHECK(looks >= 5);
  bench.edge(Edge::Source::kSwitch, 0, true);
  bench.edge(Edge::Source::kSwitch, 1, true);
  bench.pins.open = 3;
  bench.run_ms(20);
  CHECK(bench.status().phase == DropPhase::kFalling);
  bench.run_ms(5800);
  CHECK(bench.status().phase == DropPhase::kLanded && bench.card.looks <= looks + 1);
  bench.run_ms(5000);  // RAM has it: capture has ended
  CHECK(bench.status().ram_holds_drop == 1 && bench.card.looks > looks + 1);
}

// The whole logger through its cable: requests, live samples, the log of a small drop, random
// bytes.
#include <random>

#include "board_bench.h"

using namespace tfsat;
using namespace tfsat::protocol;
using tfsat_test::events_of;
using tfsat_test::Frame;
using tfsat_test::Recording;
using Bench = tfsat_test::BoardBench;

TEST_CASE(hello_and_status_tell_what_the_board_is) {
  Bench bench;
  const HelloReply hello = bench.get<HelloReply>(HelloRequest::kType);
  CHECK(hello.board == Board::kLogger);
  CHECK(std::memcmp(hello.protocol_hash, kProtocolHash, sizeof kProtocolHash) == 0);
  CHECK(std::memcmp(hello.board_serial, "EMULATED", 8) == 0);
  const LoggerStatusReply status = bench.get<LoggerStatusReply>(LoggerStatusRequest::kType);
  CHECK(status.state == LoggerState::kIdle && status.error == ErrorCode::kNone);
  CHECK(status.imu_present == 0x0F && status.switches_open == 0 && status.session == 0);
  CHECK(status.rate_hz == 280 && status.who_am_i[3] == 0x68);
  CHECK(status.uptime_ms >= 200 && status.uptime_ms <= 215);
}

TEST_CASE(a_drop_is_logged_with_its_events_and_exact_times) {
  Bench bench;
  const RecordStartReply started = bench.start(42);
  CHECK(started.state == LoggerState::kRecording && started.session != 0);
  CHECK(bench.start(42).session == started.session);
  bench.run_ms(300);
  const uint64_t release_us = bench.t_us + 123;
  bench.board.set_switch(0, false, release_us);
  bench.board.set_switch(1, false, release_us + 210);
  bench.run_ms(700);
  const uint64_t stroke_us = bench.t_us + 77;
  bench.board.stroke_edge(stroke_us);
  bench.run_ms(300);
  const RecordStopReply stopped = bench.stop();
  CHECK(stopped.session == started.session && stopped.samples_dropped == 0);
  const Recording log = bench.log();
  CHECK(log.samples.size() == stopped.samples && log.footers.size() == 1);
  CHECK(bench.card.n_blocks() == log.footers[0].blocks);
  CHECK(log.headers[0].rate_hz == 280.0f && log.headers[0].imu_present == 0x0F);
  CHECK(log.events.size() == 4);
  CHECK(log.events[0].code == EventCode::kSwitchEdge && log.events[0].time_us == release_us);
  CHECK(log.events[0].index == 0 && log.events[0].arg == 1);
  CHECK(log.events[1].index == 1 && log.events[1].time_us == release_us + 210);
  CHECK(log.events[2].code == EventCode::kRelease && log.events[2].time_us == release_us + 210);
  CHECK(log.events[3].code == EventCode::kStroke && log.events[3].time_us == stroke_us);
  CHECK(log.events[3].index == 0);
  CHECK((log.samples.front().flags & 0x0C00) == 0 && (log.samples.back().flags & 0x0C00) == 0x0C00);
  CHECK(log.footers[0].interval_min_us == 3571 && log.footers[0].interval_max_us == 3572);
}

TEST_CASE(requests_that_cannot_be_served_say_why) {
  Bench bench;
  const auto error = [&bench](uint8_t type, const std::vector<uint8_t>& payload) {
    const ErrorReply reply = bench.get<ErrorReply>(type, payload);
    CHECK(reply.request == type);
    return reply.code;
  };
  CHECK(error(RecordStopRequest::kType, {}) == ErrorCode::kNotRecording);
  CHECK(error(SequencerStatusRequest::kType, {}) == ErrorCode::kUnknownMessage);
  CHECK(error(RecordStartRequest::kType, {1, 2}) == ErrorCode::kBadLength);
  CHECK(error(HelloRequest::kType, {0}) == ErrorCode::kBadLength);
  bench.start(1);
  CHECK(bench.refused(RecordStartRequest{9, 0}).code == ErrorCode::kWrongState);
  CHECK(bench.refused(LogListRequest{0}).code == ErrorCode::kWrongState);
  CHECK(bench.refused(LogReadRequest{1, 1, 0, 1}).code == ErrorCode::kWrongState);
  CHECK(bench.refused(LogEraseRequest{1, 1}).code == ErrorCode::kWrongState);
}

TEST_CASE(live_samples_flow_at_full_rate_and_end_with_the_cable) {
  Bench bench;
  CHECK(bench.get<LiveReply>(LiveRequest::kType, {1}).enabled == 1);
  std::vector<LiveSampleStream> samples;
  for (int i = 0; i < 100; ++i) {
    bench.run_ms(10);
    for (const Frame& frame : bench.receive()) {
      CHECK(frame.type == LiveSampleStream::kType);
      samples.emplace_back().decode(frame.payload.data(), frame.payload.size());
    }
  }
  CHECK(samples.size() >= 279 && samples.size() <= 284);
  for (size_t i = 1; i < samples.size(); ++i) CHECK(samples[i].index == samples[i - 1].index + 1);
  CHECK(samples.back().sample.time_offset_us == 0 && (samples.back().sample.flags & 0x0F) == 0x0F);
  bench.board.set_cable(false);
  bench.run_ms(10);
  bench.board.set_cable(true);
  bench.run_ms(100);
  CHECK(bench.receive().empty());
}

TEST_CASE(a_host_that_does_not_read_costs_no_sample) {
  Bench bench;
  bench.get<LiveReply>(LiveRequest::kType, {1});
  bench.start(3);
  bench.run_ms(3000);  // nothing is read meanwhile
  CHECK(bench.receive().size() > 50);
  bench.get<LiveReply>(LiveRequest::kType, {0});
  const RecordStopReply stopped = bench.stop();
  CHECK(stopped.samples_dropped == 0 && stopped.samples > 840);
  CHECK(bench.log().samples.size() == stopped.samples);
}

TEST_CASE(random_bytes_neither_break_nor_stop_the_recording) {
  Bench bench;
  bench.start(4);
  std::mt19937 random(7);
  for (int round = 0; round < 400; ++round) {
    uint8_t noise[64];
    const size_t n = random() % sizeof noise;
    for (uint8_t& byte : noise) byte = static_cast<uint8_t>(random() % 4 == 0 ? 0 : random());
    bench.board.write(noise, n);
    if (random() % 4 == 0) {  // a whole frame of a random type and length
      const uint8_t type = static_cast<uint8_t>(random());
      const bool stops = type == RecordStopRequest::kType;
      std::vector<uint8_t> payload(random() % kMaxPayloadBytes);
      for (uint8_t& byte : payload) byte = static_cast<uint8_t>(random());
      if (!stops) bench.send(type, payload);
    }
    if (random() % 16 == 0) {
      bench.board.set_cable(false);
      bench.board.set_cable(true);
    }
    bench.run_ms(7);
    bench.receive();
  }
  bench.send(0, {});
  bench.run_ms(50);
  bench.receive();
  bench.get<LiveReply>(LiveRequest::kType, {0});
  const RecordStopReply stopped = bench.stop();
  CHECK(stopped.samples_dropped == 0 && stopped.samples > 770);
  CHECK(bench.log().samples.size() == stopped.samples);
}

TEST_CASE(the_same_seed_gives_the_same_card_and_each_start_another_session) {
  std::vector<uint8_t> cards[3];
  for (size_t i = 0; i < 3; ++i) {
    Bench bench(i == 2 ? 6 : 5);
    bench.start(1);
    bench.run_ms(200);
    bench.stop();
    cards[i] = bench.card.bytes();
    const uint32_t first = bench.start(1).session;
    bench.board.set_power(false);
    CHECK(bench.board.next_sample_us() == UINT64_MAX && bench.board.write(cards[i].data(), 1) == 0);
    bench.run_ms(10);
    bench.board.set_power(true);
    bench.run_ms(200);
    CHECK(bench.get<LoggerStatusReply>(LoggerStatusRequest::kType).uptime_ms < 220);
    CHECK(bench.start(1).session != first);
  }
  CHECK(cards[0] == cards[1] && cards[0] != cards[2]);
}

TEST_CASE(a_card_without_contact_during_the_fall_costs_no_sample) {
  Bench bench;
  bench.start(9);
  bench.run_ms(1100);
  bench.card.set_present(false);
  bench.run_ms(300);
  bench.card.set_present(true);
  bench.run_ms(1000);
  const RecordStopReply stopped = bench.stop();
  const Recording log = bench.log();
  CHECK(stopped.samples_dropped == 0 && log.footers.size() == 1);
  CHECK(log.samples.size() == stopped.samples);
  const std::vector<Event> stalls = events_of(log, EventCode::kCardStall);
  CHECK(stalls.size() == 1 && stalls[0].value >= 300 && stalls[0].value < 450);
  CHECK(log.events.size() == 3 && events_of(log, EventCode::kCardLost).size() == 1);
  CHECK(events_of(log, EventCode::kCardBack).size() == 1);
}

TEST_CASE(a_power_cut_leaves_what_reached_the_card) {
  Bench bench;
  bench.start(8);
  bench.run_ms(10000);  // the file is filled
  bench.board.set_power(false);
  bench.card.power_cut(emulator::PowerCut::kLosesCache);
  const Recording log = bench.log();
  CHECK(log.footers.empty() && log.headers.size() >= 2);
  // 2800 less what was still being gathered and the eight blocks in the card's own RAM
  CHECK(log.samples.size() >= 2800 - 6 - 8 * 6);
}

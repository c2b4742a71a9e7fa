// What a host may ask of the whole logger: settings, the time, its card, live samples, and what it
// may send.
#include <random>

#include "board_bench.h"

using namespace tfsat;
using namespace tfsat::protocol;
using emulator::CardDefect;
using tfsat_test::events_of;
using tfsat_test::Frame;
using tfsat_test::Recording;
using Bench = tfsat_test::BoardBench;

namespace {

LoggerSettings factory() { return logger::factory_settings(); }

LoggerSettings fast() {
  LoggerSettings settings = factory();
  settings.rate_hz = 1000;
  settings.file_mib = 4;
  settings.after_landing_s = 5;
  return settings;
}

std::vector<LiveSampleStream> live_for_ms(Bench& bench, uint32_t ms) {
  std::vector<LiveSampleStream> samples;
  for (uint32_t i = 0; i < ms / 10; ++i) {
    bench.run_ms(10);
    for (const Frame& frame : bench.receive()) {
      CHECK(frame.type == LiveSampleStream::kType);
      samples.emplace_back().decode(frame.payload.data(), frame.payload.size());
    }
  }
  return samples;
}

}  // namespace

TEST_CASE(settings_are_told_with_what_the_buses_carry) {
  Bench bench;
  const auto read = [&bench] {
    return bench.get<LoggerSettingsReadReply>(LoggerSettingsReadRequest::kType);
  };
  CHECK(read().origin == Origin::kFactory && read().settings.rate_hz == 280);
  CHECK(read().rate_max_hz == 1000);
  LoggerSettings slow = factory();
  slow.bus_khz = 100;
  slow.rate_hz = 200;
  bench.write_settings(slow);
  CHECK(read().origin == Origin::kUploaded && read().settings.bus_khz == 100);
  CHECK(read().rate_max_hz >= 200 && read().rate_max_hz < 320);
  CHECK(bench.status().settings_origin == Origin::kUploaded);
}

TEST_CASE(a_new_rate_is_sampled_live_at_once_and_after_the_next_start_until_the_cable_is_pulled) {
  Bench bench;
  bench.write_settings(fast());
  for (int boot = 0; boot < 2; ++boot) {
    CHECK(bench.get<LiveReply>(LiveRequest::kType, {1}).rate_hz == 1000);
    const std::vector<LiveSampleStream> samples = live_for_ms(bench, 1000);
    CHECK(samples.size() >= 995 && samples.size() <= 1005);
    for (size_t i = 1; i < samples.size(); ++i) {
      CHECK(samples[i].index == samples[i - 1].index + 1);  // complete
      CHECK(samples[i].time_us == samples[i - 1].time_us + 1000);
    }
    CHECK((samples.back().sample.flags & 0x0F) == 0x0F && samples.back().sample.time_offset_us == 0);
    bench.board.set_cable(false);
    bench.run_ms(10);
    bench.board.set_cable(true);
    CHECK(live_for_ms(bench, 100).empty());
    bench.board.set_power(false);
    bench.run_ms(10);
    bench.board.set_power(true);
    bench.run_ms(200);
    bench.receive();
    CHECK(bench.status().rate_hz == 1000 && bench.status().late_ticks == 0);
  }
}

TEST_CASE(settings_that_make_no_sense_are_refused_with_their_place) {
  Bench bench;
  LoggerSettings wrong = factory();
  wrong.accel_range_g = 3;
  ErrorReply reply = bench.refused(LoggerSettingsWriteRequest{wrong});
  CHECK(reply.code == ErrorCode::kLoggerSettingOutOfRange && reply.detail == 2);
  wrong = factory();
  wrong.bus_khz = 100;
  wrong.rate_hz = 1000;
  reply = bench.refused(LoggerSettingsWriteRequest{wrong});
  CHECK(reply.code == ErrorCode::kRateTooHigh && reply.detail > 200 && reply.detail < 320);
  CHECK(bench.status().rate_hz == 280);
  CHECK(bench.board.memory() == std::vector<uint8_t>(bench.board.memory().size(), 0xFF));
  bench.start(1);
  CHECK(bench.refused(LoggerSettingsWriteRequest{fast()}).code == ErrorCode::kWrongState);
  CHECK(bench.status().rate_hz == 280);
  bench.stop();
  bench.write_settings(fast());
}

TEST_CASE(the_status_tells_what_the_card_is_like) {
  Bench bench;
  bench.run_ms(2100);
  CHECK(bench.status().card == CardState::kReady && bench.status().card_free_mib == 128);
  const struct {
    CardDefect defect;
    CardState state;
  } defects[] = {{CardDefect::kWriteProtected, CardState::kWriteProtected},
                 {CardDefect::kUnreadable, CardState::kUnreadable},
                 {CardDefect::kFailing, CardState::kFailing},
                 {CardDefect::kNone, CardState::kReady}};
  for (const auto& defect : defects) {
    bench.card.set_defect(defect.defect);
    bench.run_ms(2100);
    CHECK(bench.status().card == defect.state);
  }
  bench.card.set_present(false);
  bench.run_ms(2100);
  CHECK(bench.status().card == CardState::kMissing);
  bench.card.set_present(true);
  bench.card.fill_up_to(32 * 2048 - 1);
  bench.run_ms(2100);
  CHECK(bench.status().card == CardState::kFull && bench.status().card_free_mib == 31);
  bench.write_settings(fast());  // a smaller file: looked at once more
  bench.run_ms(5);
  CHECK(bench.status().card == CardState::kReady);
}

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

TEST_CASE(each_recording_names_the_maneuver_of_its_own_start) {
  Bench bench;
  CHECK(bench.status().maneuver_known == 0);
  const RecordStartRequest starts[] = {{1, 0, 1, 0xC0DE}, {2, 0, 0, 0xBAD0}, {3, 0, 1, 0}};
  for (const RecordStartRequest& start : starts) {
    bench.start(start);
    CHECK(bench.status().maneuver_known == start.maneuver_known);
    CHECK(bench.status().maneuver_crc == start.maneuver_crc);
    bench.run_ms(200);
    bench.stop();
    const LogHeader header = bench.file(static_cast<uint16_t>(start.number)).headers.at(0);
    CHECK(header.maneuver_known == start.maneuver_known);
    CHECK(header.maneuver_crc == start.maneuver_crc);
  }
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
  CHECK(bench.refused(RecordStartRequest{9, 0, 0, 0}).code == ErrorCode::kWrongState);
  CHECK(bench.refused(LogListRequest{0}).code == ErrorCode::kWrongState);
  CHECK(bench.refused(LogReadRequest{1, 1, 0, 1}).code == ErrorCode::kWrongState);
  CHECK(bench.refused(LogEraseRequest{1, 1}).code == ErrorCode::kWrongState);
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

// Recordings that a start has given the time are the fault campaign's; here CLOCK_SET does.
TEST_CASE(every_header_tells_the_time_of_day_of_its_block) {
  constexpr uint64_t kUnixUs = 1790000000123456u;
  Bench bench;
  bench.get<ClockSetReply>(ClockSetRequest::kType, Bench::encoded(ClockSetRequest{0}));
  CHECK(bench.status().unix_us == 0);
  const std::vector<uint8_t> set = Bench::encoded(ClockSetRequest{kUnixUs});
  const uint64_t unix_at_zero_us = kUnixUs - bench.get<ClockSetReply>(ClockSetRequest::kType, set).uptime_us;
  bench.write_settings(fast());
  bench.start(1);
  const LoggerStatusReply status = bench.status();
  CHECK(status.unix_us - unix_at_zero_us - 1000ull * status.uptime_ms < 20000);
  bench.run_ms(4000);
  bench.stop();
  const Recording log = bench.log();
  CHECK(log.headers.size() >= 4);
  size_t i = 0;
  for (const BlockHeader& head : log.heads) {
    if (head.kind == BlockKind::kHeader) CHECK(log.headers[i++].wall_clock_us - head.time_us == unix_at_zero_us);
  }
  CHECK(log.headers[0].after_landing_s == 5 && log.headers[0].bus_khz == 400);
  CHECK(std::memcmp(log.headers[0].schema, kLogSchema, sizeof kLogSchema) == 0);
}

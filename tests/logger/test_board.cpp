// The whole logger through its cable: requests, live samples, the log of a small drop, random
// bytes.
#include <random>
#include <vector>

#include "boards/logger_board.h"
#include "card_image.h"
#include "check.h"
#include "sensors/mpu6050.h"

using namespace tfsat;
using namespace tfsat::protocol;
using emulator::LoggerBoard;

namespace {

struct Frame {
  uint8_t type;
  std::vector<uint8_t> payload;
};

struct Bench {
  explicit Bench(uint64_t seed = 1) : imus(4), angles(6), board(seed) {
    for (size_t i = 0; i < 4; ++i) buses[i / 2].attach(static_cast<uint8_t>(0x68 + i % 2), imus[i]);
    board.attach(buses, angles, card);
    board.set_cable(true);
    board.set_power(true);
    run_ms(200);
  }

  void run_ms(uint64_t ms) {
    for (const uint64_t end_us = t_us + 1000 * ms; t_us < end_us;) {
      t_us += 500;
      for (emulator::Mpu6050& imu : imus) imu.sample(t_us, {0.5, 0, 0}, {0, 0, 9.80665}, 25.0);
      board.advance_to(t_us);
    }
  }
  void send(uint8_t type, const std::vector<uint8_t>& payload, uint8_t sequence = 9) {
    uint8_t frame[encoded_frame_bytes(kMaxPayloadBytes)];
    const size_t n = encode_frame(type, sequence, payload.data(), payload.size(), frame);
    CHECK(board.write(frame, n) == n);
  }
  std::vector<Frame> receive() {
    std::vector<Frame> frames;
    uint8_t bytes[512];
    for (size_t n = board.read(bytes, sizeof bytes); n > 0; n = board.read(bytes, sizeof bytes)) {
      for (size_t i = 0; i < n; ++i) {
        if (!receiver.feed(bytes[i])) continue;
        const uint8_t* payload = receiver.payload();
        frames.push_back({receiver.type(), {payload, payload + receiver.payload_bytes()}});
      }
    }
    return frames;
  }
  // The reply to one request; live samples in between are passed over.
  Frame ask(uint8_t type, const std::vector<uint8_t>& payload = {}) {
    send(type, payload);
    run_ms(5);
    for (const Frame& frame : receive()) {
      if (frame.type != LiveSampleStream::kType) return frame;
    }
    return {0, {}};
  }
  template <typename Reply>
  Reply get(uint8_t type, const std::vector<uint8_t>& payload = {}) {
    const Frame frame = ask(type, payload);
    Reply reply = {};
    CHECK(frame.type == Reply::kType && reply.decode(frame.payload.data(), frame.payload.size()));
    return reply;
  }
  RecordStartReply start(uint32_t number) {
    const RecordStartRequest request{number};
    std::vector<uint8_t> payload(RecordStartRequest::kSize);
    request.encode(payload.data());
    return get<RecordStartReply>(RecordStartRequest::kType, payload);
  }
  RecordStopReply stop() {
    for (int i = 0; i < 400; ++i) {
      const RecordStopReply reply = get<RecordStopReply>(RecordStopRequest::kType);
      if (reply.state == LoggerState::kStopped) return reply;
    }
    CHECK(!"stopped");
    return {};
  }
  tfsat_test::Recording log() {
    const std::vector<uint8_t> bytes = card.bytes();
    std::vector<logger::Block> blocks(bytes.size() / kBlockBytes);
    for (size_t i = 0; i < blocks.size(); ++i) {
      std::memcpy(blocks[i].bytes, bytes.data() + i * kBlockBytes, kBlockBytes);
    }
    return tfsat_test::read_recording(blocks, blocks.size());
  }

  std::array<emulator::I2cBus, 2> buses;
  std::vector<emulator::Mpu6050> imus;
  std::vector<emulator::AngleSensor> angles;
  emulator::BlockDevice card{emulator::CardParameters{250, 1000, 8}};
  LoggerBoard board;
  FrameReceiver<kMaxPayloadBytes> receiver;
  uint64_t t_us = 0;
};

}  // namespace

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
  bench.run_ms(100);
  const uint64_t release_us = bench.t_us + 123;
  bench.board.set_switch(0, false, release_us);
  bench.board.set_switch(1, false, release_us + 210);
  bench.run_ms(700);
  const uint64_t stroke_us = bench.t_us + 77;
  bench.board.stroke_edge(stroke_us);
  bench.run_ms(300);
  const RecordStopReply stopped = bench.stop();
  CHECK(stopped.session == started.session && stopped.samples_dropped == 0);
  const tfsat_test::Recording log = bench.log();
  CHECK(log.samples.size() == stopped.samples && log.footers.size() == 1);
  CHECK(bench.card.n_blocks() == log.footers[0].blocks);
  CHECK(log.headers[0].rate_hz == 280.0f && log.headers[0].imu_present == 0x0F);
  CHECK(log.events.size() == 3);
  CHECK(log.events[0].code == EventCode::kSwitchEdge && log.events[0].time_us == release_us);
  CHECK(log.events[0].index == 0 && log.events[0].arg == 1);
  CHECK(log.events[1].index == 1 && log.events[1].time_us == release_us + 210);
  CHECK(log.events[2].code == EventCode::kStroke && log.events[2].time_us == stroke_us);
  CHECK(log.events[2].index == 0);
  CHECK((log.samples.front().flags & 0x0C00) == 0 && (log.samples.back().flags & 0x0C00) == 0x0C00);
  CHECK(log.footers[0].interval_min_us == 3571 && log.footers[0].interval_max_us == 3572);
}

TEST_CASE(requests_that_cannot_be_served_say_why) {
  Bench bench;
  const auto error = [&bench](uint8_t type, const std::vector<uint8_t>& payload) {
    const ErrorReply reply = [&] {
      const Frame frame = bench.ask(type, payload);
      ErrorReply decoded = {};
      CHECK(frame.type == ErrorReply::kType);
      CHECK(decoded.decode(frame.payload.data(), frame.payload.size()));
      return decoded;
    }();
    CHECK(reply.request == type);
    return reply.code;
  };
  CHECK(error(RecordStopRequest::kType, {}) == ErrorCode::kNotRecording);
  CHECK(error(SequencerStatusRequest::kType, {}) == ErrorCode::kUnknownMessage);
  CHECK(error(RecordStartRequest::kType, {1, 2}) == ErrorCode::kBadLength);
  CHECK(error(HelloRequest::kType, {0}) == ErrorCode::kBadLength);
  bench.card.set_present(false);
  CHECK(error(RecordStartRequest::kType, {1, 2, 3, 4}) == ErrorCode::kNoCard);
  bench.card.set_present(true);
  bench.start(1);
  CHECK(error(RecordStartRequest::kType, {9, 9, 9, 9}) == ErrorCode::kWrongState);
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
  const tfsat_test::Recording log = bench.log();
  CHECK(stopped.samples_dropped == 0 && log.footers.size() == 1);
  CHECK(log.samples.size() == stopped.samples);
  CHECK(log.events.size() == 1 && log.events[0].code == EventCode::kCardStall);
  CHECK(log.events[0].value >= 300 && log.events[0].value < 450);
}

TEST_CASE(a_power_cut_leaves_what_reached_the_card) {
  Bench bench;
  bench.start(8);
  bench.run_ms(1000);
  bench.board.set_power(false);
  bench.card.power_cut(emulator::PowerCut::kLosesCache);
  const tfsat_test::Recording log = bench.log();
  CHECK(log.footers.empty() && log.headers.size() == 2);
  // 280 less what was still being gathered and the eight blocks in the card's own RAM
  CHECK(log.samples.size() >= 280 - 6 - 8 * 6);
}

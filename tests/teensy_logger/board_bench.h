// The emulated logger with its sensors and card, and a host at its cable.
#pragma once

#include <array>
#include <cstring>
#include <vector>

#include "boards/logger_board.h"
#include "check.h"
#include "recording.h"
#include "sensors/mpu6050.h"

namespace tfsat_test {

using namespace tfsat;
using namespace tfsat::protocol;

struct Frame {
  uint8_t type;
  std::vector<uint8_t> payload;
};

struct BoardBench {
  static constexpr emulator::CardParameters kCard{250, 1000, 8, 1u << 18};  // 128 MiB

  explicit BoardBench(uint64_t seed = 1, const emulator::CardParameters& of_card = kCard)
      : imus(4), angles(6), card(of_card), board(seed) {
    for (size_t i = 0; i < 4; ++i) buses[i / 2].attach(static_cast<uint8_t>(0x68 + i % 2), imus[i]);
    board.attach(buses, angles, card);
    board.set_cable(true);
    board.set_power(true);
    run_ms(200);
  }

  void run_ms(uint64_t ms) {
    run_until(t_us + 1000 * ms);
  }
  void run_until(uint64_t end_us) {
    while (t_us < end_us) {
      t_us += 500;
      for (emulator::Mpu6050& imu : imus) imu.sample(t_us, {0.5, 0, 0}, {0, 0, force_m_s2}, 25.0);
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
  template <typename Request>
  static std::vector<uint8_t> encoded(const Request& request) {
    std::vector<uint8_t> payload(Request::kSize);
    request.encode(payload.data());
    return payload;
  }
  template <typename Reply>
  Reply get(uint8_t type, const std::vector<uint8_t>& payload = {}) {
    const Frame frame = ask(type, payload);
    Reply reply = {};
    CHECK(frame.type == Reply::kType && reply.decode(frame.payload.data(), frame.payload.size()));
    return reply;
  }
  // The error that a request is refused with.
  template <typename Request>
  ErrorReply refused(const Request& request) {
    return get<ErrorReply>(Request::kType, encoded(request));
  }
  LoggerStatusReply status() { return get<LoggerStatusReply>(LoggerStatusRequest::kType); }
  RecordStartReply start(uint32_t number, uint64_t unix_us = 0) {
    return start(RecordStartRequest{number, unix_us, 0, 0});
  }
  RecordStartReply start(const RecordStartRequest& request) {
    return get<RecordStartReply>(RecordStartRequest::kType, encoded(request));
  }
  void write_settings(const LoggerSettings& settings) {
    const std::vector<uint8_t> payload = encoded(LoggerSettingsWriteRequest{settings});
    CHECK(get<LoggerSettingsWriteReply>(LoggerSettingsWriteRequest::kType, payload).stored == 1);
  }
  void release() {
    board.set_switch(0, false);
    board.set_switch(1, false);
  }
  void land() {
    force_m_s2 = 120.0;
    run_ms(40);
    force_m_s2 = 9.80665;
  }
  RecordStopReply stop() {
    for (int i = 0; i < 400; ++i) {
      const RecordStopReply reply = get<RecordStopReply>(RecordStopRequest::kType);
      if (reply.state == LoggerState::kStopped) return reply;
    }
    CHECK(!"stopped");
    return {};
  }
  Recording log() const { return recording_in(card.bytes()); }
  Recording file(uint16_t number) const { return recording_in(card.file(number)); }
  static Recording recording_in(const std::vector<uint8_t>& bytes) {
    std::vector<logger::Block> blocks(bytes.size() / kBlockBytes);
    for (size_t i = 0; i < blocks.size(); ++i) {
      std::memcpy(blocks[i].bytes, bytes.data() + i * kBlockBytes, kBlockBytes);
    }
    return read_recording(blocks, blocks.size());
  }
  // A release, its fall and its landing, and some time more.
  void drop(uint64_t then_ms) {
    release();
    run_ms(2500);
    land();
    run_ms(then_ms);
  }

  std::array<emulator::I2cBus, 2> buses;
  std::vector<emulator::Mpu6050> imus;
  std::vector<emulator::AngleSensor> angles;
  emulator::BlockDevice card;
  emulator::LoggerBoard board;
  FrameReceiver<kMaxPayloadBytes> receiver;
  uint64_t t_us = 0;
  double force_m_s2 = 9.80665;
};

}  // namespace tfsat_test

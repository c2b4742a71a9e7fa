#include "logger.h"

#include <string.h>

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::Reply;

Logger::Logger(const Ports& ports, const Identity& identity, const Settings& settings,
               Block* ring_blocks, uint32_t ring_capacity)
    : sampler_(ports.bus_a, ports.bus_b, ports.adc, ports.inputs),
      recorder_(ring_blocks, ring_capacity, ports.card),
      inputs_(ports.inputs),
      link_(ports.stream, *this),
      stream_(ports.stream),
      entropy_(ports.entropy),
      identity_(identity),
      settings_(settings) {}

// ------------------------------------------------------------------------------ sampling interrupt

void Logger::sample(uint64_t t_us) {
  sampler_.sample(t_us, instant_);
  collect_events(instant_);
  recorder_.capture(t_us, instant_.sample, events_);
  if (live_.load(std::memory_order_relaxed)) {
    protocol::LiveSampleStream live;
    live.index = sample_index_;
    live.time_us = t_us;
    live.sample = instant_.sample;
    live_samples_.push(live);  // full: skipped, which the index shows
  }
  ++sample_index_;
}

void Logger::collect_events(const Instant& instant) {
  if (!recorder_.capturing()) strokes_ = 0;
  for (uint8_t i = 0; i < instant.event_count; ++i) events_.push(instant.events[i]);
  protocol::Event event = {};
  while (!events_.full() && recorder_.take_card_event(event)) events_.push(event);
  Edge edge;
  while (!events_.full() && inputs_.take_edge(edge)) {
    event = {};
    event.time_us = edge.t_us;
    event.value = edge.lost;
    if (edge.source == Edge::Source::kStroke) {
      event.code = protocol::EventCode::kStroke;
      event.index = strokes_++;
    } else {
      event.code = protocol::EventCode::kSwitchEdge;
      event.index = edge.index;
      event.arg = edge.open ? 1 : 0;
    }
    events_.push(event);
  }
}

// --------------------------------------------------------------------------------------- main loop

void Logger::poll(uint64_t t_us) {
  now_us_ = t_us;
  recorder_.poll(t_us);
  link_.poll();
  if (!stream_.connected()) live_ = false;
  send_live();
}

void Logger::send_live() {
  if (!live_) {
    live_samples_.clear();
    return;
  }
  const protocol::LiveSampleStream* sample = live_samples_.front();
  if (sample == nullptr) return;
  uint8_t payload[protocol::LiveSampleStream::kSize];
  sample->encode(payload);
  if (link_.send_stream(protocol::LiveSampleStream::kType, payload, sizeof payload)) {
    live_samples_.pop();
  }
}

bool Logger::light(uint64_t t_us) const {
  constexpr uint8_t kAllImus = (1u << protocol::kImuCount) - 1;
  const uint32_t t_ms = static_cast<uint32_t>(t_us / 1000);
  if (state() == protocol::LoggerState::kFailed || sampler_.imu_present() != kAllImus) {
    return t_ms % 200 < 100;
  }
  if (state() == protocol::LoggerState::kRecording) return true;
  return t_ms % 2000 < 50;
}

Reply Logger::handle(uint8_t type, const uint8_t* payload, size_t size, uint8_t* reply) {
  const bool empty = size == 0;
  switch (type) {
    case protocol::HelloRequest::kType:
      return empty ? hello(reply) : Reply::refused(ErrorCode::kBadLength);
    case protocol::LoggerStatusRequest::kType:
      return empty ? status(reply) : Reply::refused(ErrorCode::kBadLength);
    case protocol::RecordStartRequest::kType:
      return record_start(payload, size, reply);
    case protocol::RecordStopRequest::kType:
      return empty ? record_stop(reply) : Reply::refused(ErrorCode::kBadLength);
    case protocol::LiveRequest::kType:
      return live(payload, size, reply);
    default:
      return Reply::refused(ErrorCode::kUnknownMessage);
  }
}

Reply Logger::hello(uint8_t* reply) const {
  protocol::HelloReply hello;
  hello.board = protocol::Board::kLogger;
  memcpy(hello.firmware_version, protocol::kFirmwareVersion, sizeof hello.firmware_version);
  memcpy(hello.board_serial, identity_.board_serial, sizeof hello.board_serial);
  hello.image_crc = identity_.image_crc;
  memcpy(hello.protocol_hash, protocol::kProtocolHash, sizeof hello.protocol_hash);
  hello.encode(reply);
  return Reply::of(protocol::HelloReply::kSize);
}

Reply Logger::status(uint8_t* reply) {
  protocol::LoggerStatusReply status;
  status.state = recorder_.state();
  status.error = recorder_.error();
  status.imu_present = sampler_.imu_present();
  status.switches_open = inputs_.switches_open();
  status.session = recorder_.session();
  status.samples = recorder_.samples();
  status.samples_dropped = recorder_.samples_dropped();
  status.blocks_written = recorder_.blocks_written();
  status.ring_blocks = static_cast<uint16_t>(recorder_.ring_blocks());
  status.ring_peak_blocks = static_cast<uint16_t>(recorder_.ring_peak_blocks());
  status.rate_hz = settings_.rate_hz;
  sampler_.copy_who_am_i(status.who_am_i);
  status.uptime_ms = static_cast<uint32_t>(now_us_ / 1000);
  status.encode(reply);
  return Reply::of(protocol::LoggerStatusReply::kSize);
}

Reply Logger::record_start(const uint8_t* payload, size_t size, uint8_t* reply) {
  protocol::RecordStartRequest request;
  if (!request.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  if (!recorder_.knows(request.number)) {
    const ErrorCode error =
        recorder_.start(request.number, new_session(), log_header(), settings_.file_blocks);
    if (error != ErrorCode::kNone) return Reply::refused(error);
  }
  protocol::RecordStartReply started;
  started.state = recorder_.state();
  started.session = recorder_.session();
  started.encode(reply);
  return Reply::of(protocol::RecordStartReply::kSize);
}

// 0 stands for "none yet".
uint32_t Logger::new_session() {
  const uint32_t session = entropy_.next();
  return session != 0 ? session : 1;
}

Reply Logger::record_stop(uint8_t* reply) {
  const ErrorCode error = recorder_.stop();
  if (error != ErrorCode::kNone) return Reply::refused(error);
  protocol::RecordStopReply stopped;
  stopped.state = recorder_.state();
  stopped.session = recorder_.session();
  stopped.samples = recorder_.samples();
  stopped.samples_dropped = recorder_.samples_dropped();
  stopped.encode(reply);
  return Reply::of(protocol::RecordStopReply::kSize);
}

Reply Logger::live(const uint8_t* payload, size_t size, uint8_t* reply) {
  protocol::LiveRequest request;
  if (!request.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  live_ = request.enabled != 0;
  protocol::LiveReply live;
  live.enabled = live_ ? 1 : 0;
  live.rate_hz = settings_.rate_hz;
  live.gyro_lsb_per_deg_s = mpu6050::kGyroLsbPerDegS;
  live.accel_lsb_per_g = mpu6050::kAccelLsbPerG;
  live.angle_counts_per_turn = kAngleCountsPerTurn;
  live.encode(reply);
  return Reply::of(protocol::LiveReply::kSize);
}

protocol::LogHeader Logger::log_header() const {
  protocol::LogHeader header;
  memcpy(header.protocol_hash, protocol::kProtocolHash, sizeof header.protocol_hash);
  memcpy(header.firmware_version, protocol::kFirmwareVersion, sizeof header.firmware_version);
  header.imu_present = sampler_.imu_present();
  memcpy(header.board_serial, identity_.board_serial, sizeof header.board_serial);
  header.image_crc = identity_.image_crc;
  header.rate_hz = settings_.rate_hz;
  header.gyro_lsb_per_deg_s = mpu6050::kGyroLsbPerDegS;
  header.accel_lsb_per_g = mpu6050::kAccelLsbPerG;
  header.temperature_lsb_per_c = mpu6050::kTemperatureLsbPerC;
  header.temperature_offset_c = mpu6050::kTemperatureOffsetC;
  header.angle_counts_per_turn = kAngleCountsPerTurn;
  header.gyro_range_deg_s = mpu6050::kGyroRangeDegS;
  header.accel_range_g = mpu6050::kAccelRangeG;
  header.dlpf_cfg = mpu6050::kDlpfCfg;
  sampler_.copy_who_am_i(header.who_am_i);
  header.wall_clock_us = 0;  // no host has set the clock
  return header;
}

}  // namespace logger
}  // namespace tfsat

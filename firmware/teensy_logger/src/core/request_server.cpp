#include "request_server.h"

#include <string.h>

#include "mpu6050.h"
#include "timing.h"

namespace tfsat {
namespace logger {

using protocol::ErrorCode;
using protocol::Reply;

namespace {

template <typename Message>
Reply encoded(const Message& message, uint8_t* reply) {
  message.encode(reply);
  return Reply::of(Message::kSize);
}

}  // namespace

Reply RequestServer::handle(uint8_t type, const uint8_t* payload, size_t size, uint8_t* reply) {
  using namespace protocol;
  const bool empty = size == 0;
  switch (type) {
    case HelloRequest::kType:
      return empty ? hello(reply) : Reply::refused(ErrorCode::kBadLength);
    case LoggerStatusRequest::kType:
      return empty ? status(reply) : Reply::refused(ErrorCode::kBadLength);
    case RecordStopRequest::kType:
      return empty ? record_stop(reply) : Reply::refused(ErrorCode::kBadLength);
    case LoggerSettingsReadRequest::kType:
      return empty ? settings_read(reply) : Reply::refused(ErrorCode::kBadLength);
    case RecordStartRequest::kType:
      return serve(&RequestServer::record_start, payload, size, reply);
    case LiveRequest::kType:
      return serve(&RequestServer::live, payload, size, reply);
    case LoggerSettingsWriteRequest::kType:
      return serve(&RequestServer::settings_write, payload, size, reply);
    case ClockSetRequest::kType:
      return serve(&RequestServer::clock_set, payload, size, reply);
    case LogListRequest::kType:
      return serve(&RequestServer::log_list, payload, size, reply);
    case LogReadRequest::kType:
      return serve(&RequestServer::log_read, payload, size, reply);
    case LogEraseRequest::kType:
      return serve(&RequestServer::log_erase, payload, size, reply);
    default:
      return Reply::refused(ErrorCode::kUnknownMessage);
  }
}

Reply RequestServer::hello(uint8_t* reply) const {
  protocol::HelloReply hello;
  hello.board = protocol::Board::kLogger;
  memcpy(hello.firmware_version, protocol::kFirmwareVersion, sizeof hello.firmware_version);
  memcpy(hello.board_serial, identity_.board_serial, sizeof hello.board_serial);
  hello.image_crc = identity_.image_crc;
  memcpy(hello.protocol_hash, protocol::kProtocolHash, sizeof hello.protocol_hash);
  return encoded(hello, reply);
}

Reply RequestServer::status(uint8_t* reply) {
  const Recorder& recorder = parts_.recorder;
  protocol::LoggerStatusReply status;
  status.state = recorder.state();
  status.error = recorder.error();
  status.imu_present = parts_.sampler.imu_present();
  status.switches_open = parts_.inputs.switches_open();
  status.session = recorder.session();
  status.samples = recorder.samples();
  status.samples_dropped = recorder.samples_dropped();
  status.blocks_written = recorder.blocks_written();
  status.ring_blocks = static_cast<uint16_t>(recorder.ring_blocks());
  status.ring_peak_blocks = static_cast<uint16_t>(recorder.ring_peak_blocks());
  status.rate_hz = parts_.settings.settings().rate_hz;
  parts_.sampler.copy_who_am_i(status.who_am_i);
  status.uptime_ms = static_cast<uint32_t>(now_us_ / 1000);
  status.card = card_state();
  status.card_free_mib = parts_.card.free_mib();
  status.phase = recorder.phase();
  status.ram_holds_drop = recorder.ram_holds_drop() ? 1 : 0;
  status.late_ticks = control_.late_ticks();
  status.settings_origin = parts_.settings.origin();
  status.unix_us = unix_at_zero_us_ == 0 ? 0 : unix_at_zero_us_ + now_us_;
  status.maneuver_known = recorder.header().maneuver_known;
  status.maneuver_crc = recorder.header().maneuver_crc;
  return encoded(status, reply);
}

// While a file is open, what its writer meets; else what the watch has seen.
protocol::CardState RequestServer::card_state() const {
  return parts_.recorder.uses_card() ? CardWatch::state_of(parts_.recorder.card_trouble())
                                     : parts_.card_watch.state();
}

Reply RequestServer::settings_read(uint8_t* reply) {
  protocol::LoggerSettingsReadReply read;
  read.origin = parts_.settings.origin();
  read.settings = parts_.settings.settings();
  read.rate_max_hz = max_rate_hz(read.settings.bus_khz);
  return encoded(read, reply);
}

Reply RequestServer::settings_write(const protocol::LoggerSettingsWriteRequest& request,
                                    uint8_t* reply) {
  if (busy()) return Reply::refused(ErrorCode::kWrongState);
  int32_t detail = -1;
  const ErrorCode error = check(request.settings, detail);
  if (error != ErrorCode::kNone) return Reply::refused(error, detail);
  if (!control_.apply(request.settings)) return Reply::refused(ErrorCode::kStoreFailed);
  parts_.card_watch.look_again();  // its file may need more room now
  protocol::LoggerSettingsWriteReply written;
  written.stored = 1;
  return encoded(written, reply);
}

Reply RequestServer::record_start(const protocol::RecordStartRequest& request, uint8_t* reply) {
  Recorder& recorder = parts_.recorder;
  if (!recorder.knows(request.number)) {
    if (!recorder.uses_card() && !card_is_counted()) return Reply::refused(ErrorCode::kBusy);
    if (request.unix_us != 0) set_clock(request.unix_us);
    parts_.log_server.end();
    Recorder::Plan next = plan();
    next.header.maneuver_known = request.maneuver_known;
    next.header.maneuver_crc = request.maneuver_crc;
    const ErrorCode error = recorder.start(request.number, next);
    if (error != ErrorCode::kNone) return Reply::refused(error);
    parts_.card_watch.look_again();
  }
  protocol::RecordStartReply started;
  started.state = recorder.state();
  started.session = recorder.session();
  return encoded(started, reply);
}

void RequestServer::start_next_file() {
  Recorder::Plan next = plan();
  next.header.maneuver_known = parts_.recorder.header().maneuver_known;
  next.header.maneuver_crc = parts_.recorder.header().maneuver_crc;
  parts_.recorder.start_next_file(next);
}

Recorder::Plan RequestServer::plan() const {
  const protocol::LoggerSettings& settings = parts_.settings.settings();
  Recorder::Plan plan;
  plan.session = control_.new_session();
  plan.header = log_header();
  plan.unix_at_zero_us = unix_at_zero_us_;
  plan.file_blocks = file_blocks(settings);
  plan.after_landing_s = settings.after_landing_s;
  return plan;
}

Reply RequestServer::record_stop(uint8_t* reply) {
  Recorder& recorder = parts_.recorder;
  const ErrorCode error = recorder.stop();
  if (error != ErrorCode::kNone) return Reply::refused(error);
  protocol::RecordStopReply stopped;
  stopped.state = recorder.state();
  stopped.session = recorder.session();
  stopped.samples = recorder.samples();
  stopped.samples_dropped = recorder.samples_dropped();
  return encoded(stopped, reply);
}

Reply RequestServer::live(const protocol::LiveRequest& request, uint8_t* reply) {
  control_.set_live(request.enabled != 0);
  const protocol::LoggerSettings& settings = parts_.settings.settings();
  protocol::LiveReply live;
  live.enabled = control_.live() ? 1 : 0;
  live.rate_hz = settings.rate_hz;
  live.gyro_lsb_per_deg_s = gyro_lsb_per_deg_s(settings);
  live.accel_lsb_per_g = accel_lsb_per_g(settings);
  live.angle_counts_per_turn = kAngleCountsPerTurn;
  live.dlpf_cfg = settings.dlpf_cfg;
  parts_.sampler.copy_who_am_i(live.who_am_i);
  put_offsets(settings.bus_khz, live);
  return encoded(live, reply);
}

Reply RequestServer::clock_set(const protocol::ClockSetRequest& request, uint8_t* reply) {
  set_clock(request.unix_us);
  protocol::ClockSetReply set;
  set.uptime_us = now_us_;
  return encoded(set, reply);
}

ErrorCode RequestServer::no_card_access() {
  if (busy()) return ErrorCode::kWrongState;
  return card_is_counted() ? ErrorCode::kNone : ErrorCode::kBusy;
}

Reply RequestServer::log_list(const protocol::LogListRequest& request, uint8_t* reply) {
  const ErrorCode refusal = no_card_access();
  if (refusal != ErrorCode::kNone) return Reply::refused(refusal);
  return encoded(parts_.log_server.list(request.from_number), reply);
}

// A file is not there, too, when its card is gone.
ErrorCode RequestServer::why_no_log(uint16_t number, ErrorCode error) {
  if (error != ErrorCode::kNoSuchLog || number == 0) return error;
  const ErrorCode card = parts_.card.inspect(0);
  return card == ErrorCode::kNone ? error : card;
}

Reply RequestServer::log_read(const protocol::LogReadRequest& request, uint8_t* reply) {
  const ErrorCode refusal = no_card_access();
  if (refusal != ErrorCode::kNone) return Reply::refused(refusal);
  protocol::LogReadReply read;
  const ErrorCode error =
      why_no_log(request.number, parts_.log_server.begin_read(request, read.count));
  if (error != ErrorCode::kNone) return Reply::refused(error);
  return encoded(read, reply);
}

Reply RequestServer::log_erase(const protocol::LogEraseRequest& request, uint8_t* reply) {
  const ErrorCode refusal = no_card_access();
  if (refusal != ErrorCode::kNone) return Reply::refused(refusal);
  const ErrorCode error = why_no_log(request.number, parts_.log_server.erase(request));
  if (error != ErrorCode::kNone) return Reply::refused(error);
  parts_.card_watch.look_again();
  protocol::LogEraseReply erased;
  erased.erased = 1;
  return encoded(erased, reply);
}

protocol::LogHeader RequestServer::log_header() const {
  const protocol::LoggerSettings& settings = parts_.settings.settings();
  protocol::LogHeader header = {};
  memcpy(header.protocol_hash, protocol::kProtocolHash, sizeof header.protocol_hash);
  memcpy(header.firmware_version, protocol::kFirmwareVersion, sizeof header.firmware_version);
  header.imu_present = parts_.sampler.imu_present();
  memcpy(header.board_serial, identity_.board_serial, sizeof header.board_serial);
  header.image_crc = identity_.image_crc;
  header.rate_hz = settings.rate_hz;
  header.gyro_lsb_per_deg_s = gyro_lsb_per_deg_s(settings);
  header.accel_lsb_per_g = accel_lsb_per_g(settings);
  header.temperature_lsb_per_c = protocol::kImuParts[0].temperature_lsb_per_c;
  header.temperature_offset_c = protocol::kImuParts[0].temperature_offset_c;
  header.angle_counts_per_turn = kAngleCountsPerTurn;
  header.gyro_range_deg_s = settings.gyro_range_deg_s;
  header.accel_range_g = settings.accel_range_g;
  header.dlpf_cfg = settings.dlpf_cfg;
  parts_.sampler.copy_who_am_i(header.who_am_i);
  header.bus_khz = settings.bus_khz;
  header.after_landing_s = settings.after_landing_s;
  put_offsets(settings.bus_khz, header);
  static_assert(sizeof protocol::kLogSchema <= sizeof header.schema, "with its final zero");
  memcpy(header.schema, protocol::kLogSchema, sizeof protocol::kLogSchema);
  return header;
}

}  // namespace logger
}  // namespace tfsat

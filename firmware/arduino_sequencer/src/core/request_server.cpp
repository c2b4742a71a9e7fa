#include "request_server.h"

#include <string.h>

namespace tfsat {
namespace sequencer {

using namespace protocol;

namespace {

template <typename Message>
Reply send(const Message& message, uint8_t* reply) {
  message.encode(reply);
  return Reply::of(Message::kSize);
}

// As a bit of stores_damaged, for the maneuver's store.
uint8_t defect_bit(ErrorCode defect) {
  switch (defect) {
    case ErrorCode::kStoreDamaged:
      return 1;
    case ErrorCode::kUploadInterrupted:
      return 4;
    case ErrorCode::kStoreOldLayout:
      return 16;
    default:
      return 0;
  }
}

Reply refuse(const Defect& defect) { return Reply::refused(defect.code, defect.stroke); }

}  // namespace

Reply RequestServer::handle(uint8_t type, const uint8_t* payload, size_t size, uint8_t* reply) {
  switch (type) {
    case ManeuverBeginRequest::kType:
      return maneuver_begin(payload, size, reply);
    case ManeuverStrokeRequest::kType:
      return maneuver_stroke(payload, size, reply);
    case ManeuverCommitRequest::kType:
      return maneuver_commit(payload, size, reply);
    case ManeuverReadRequest::kType:
      return maneuver_read(payload, size, reply);
    case SettingsWriteRequest::kType:
      return settings_write(payload, size, reply);
    case JointReportRequest::kType:
      return joint_report(payload, size, reply);
    case JogRequest::kType:
      return jog(payload, size, reply);
    case ArmRequest::kType:
      return arm(payload, size, reply);
    case HelloRequest::kType:
    case SequencerStatusRequest::kType:
    case RunReportRequest::kType:
    case SettingsReadRequest::kType:
    case ManeuverInfoRequest::kType:
    case DisarmRequest::kType:
      break;
    default:
      return Reply::refused(ErrorCode::kUnknownMessage);
  }
  if (size != 0) return Reply::refused(ErrorCode::kBadLength);
  if (type == HelloRequest::kType) return hello(reply);
  if (type == SequencerStatusRequest::kType) return status(reply);
  if (type == RunReportRequest::kType) return send(sequencer_.run_report(), reply);
  if (type == SettingsReadRequest::kType) return settings_read(reply);
  if (type == ManeuverInfoRequest::kType) return maneuver_info(reply);
  return disarm(reply);
}

Reply RequestServer::hello(uint8_t* reply) {
  HelloReply hello;
  hello.board = Board::kSequencer;
  memcpy(hello.firmware_version, kFirmwareVersion, sizeof hello.firmware_version);
  memcpy(hello.board_serial, identity_.board_serial, sizeof hello.board_serial);
  hello.image_crc = identity_.image_crc;
  memcpy(hello.protocol_hash, kProtocolHash, sizeof hello.protocol_hash);
  return send(hello, reply);
}

Reply RequestServer::status(uint8_t* reply) {
  SequencerStatusReply status;
  status.state = sequencer_.state();
  status.fault = sequencer_.fault();
  status.last_refusal = sequencer_.last_refusal();
  status.switches_open = sequencer_.switches_open();
  status.arm_token = sequencer_.arm_token();
  status.reset_cause = identity_.reset_cause;
  status.resets_while_armed = sequencer_.resets_while_armed();
  status.strokes_started = sequencer_.strokes_started();
  status.knocks = sequencer_.knocks();
  memcpy(status.joint_angle_cdeg, sequencer_.held_cdeg(), sizeof status.joint_angle_cdeg);
  status.uptime_ms = sequencer_.uptime_ms();
  status.image_crc = identity_.image_crc;
  status.ram_never_used_bytes = health_.ram_never_used_bytes();
  status.frames_rejected = frames_rejected_;
  status.stores_damaged = static_cast<uint8_t>(defect_bit(sequencer_.maneuvers().defect()) |
                                               defect_bit(sequencer_.settings().defect()) << 1);
  status.false_releases = sequencer_.false_releases();
  status.servos_driven = sequencer_.driven();
  status.brown_out_level = identity_.brown_out_level;
  return send(status, reply);
}

Reply RequestServer::maneuver_begin(const uint8_t* payload, size_t size, uint8_t* reply) {
  ManeuverBeginRequest request;
  if (!request.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  if (!sequencer_.may_upload() || sequencer_.maneuvers().committing()) {
    return Reply::refused(ErrorCode::kWrongState);
  }
  const Defect defect = upload_.begin(request.stroke_count, request.speed_cdeg_s);
  if (defect.code != ErrorCode::kNone) return refuse(defect);
  sequencer_.maneuvers().forget_last();
  sequencer_.maneuvers().begin();
  maneuver_written_ = false;
  ManeuverBeginReply answer;
  answer.stroke_count = request.stroke_count;
  return send(answer, reply);
}

Reply RequestServer::maneuver_stroke(const uint8_t* payload, size_t size, uint8_t* reply) {
  ManeuverStrokeRequest request;
  if (!request.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  if (!sequencer_.may_upload() || sequencer_.maneuvers().committing()) {
    return Reply::refused(ErrorCode::kWrongState);
  }
  const Defect defect =
      upload_.put(request.index, Stroke{request.joint, request.angle_cdeg, request.start_us});
  if (defect.code != ErrorCode::kNone) return refuse(defect);
  ManeuverStrokeReply answer;
  answer.index = request.index;
  return send(answer, reply);
}

Reply RequestServer::maneuver_commit(const uint8_t* payload, size_t size, uint8_t* reply) {
  ManeuverCommitRequest request;
  if (!request.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  if (!sequencer_.may_upload()) return Reply::refused(ErrorCode::kWrongState);
  const Defect defect = upload_.find_defect(request.crc);
  if (defect.code != ErrorCode::kNone) return refuse(defect);
  return store_staged(sequencer_.maneuvers(), maneuver_written_, reply);
}

// The copy of a request that finds the record stored says so; those before it begin or await it.
Reply RequestServer::store_staged(SlotPair& store, bool& written, uint8_t* reply) {
  static_assert(SettingsWriteReply::kSize == ManeuverCommitReply::kSize, "one answer for both");
  if (store.failed()) {
    store.forget_last();  // told once; the next copy tries again
    return Reply::refused(ErrorCode::kStoreFailed);
  }
  written = written || store.changed();
  const bool beginning = store.writing() && !store.committing();
  if (beginning || !sequencer_.storing()) {
    store.commit();
    written = written || store.changed();
  }
  ManeuverCommitReply answer;
  answer.stored = sequencer_.storing() ? 0 : 1;
  answer.written = written ? 1 : 0;
  return send(answer, reply);
}

Reply RequestServer::maneuver_info(uint8_t* reply) {
  const Stored<Maneuver>& store = sequencer_.maneuvers();
  const Maneuver& maneuver = store.current();
  ManeuverInfoReply info;
  info.origin = store.origin();
  info.stroke_count = maneuver.stroke_count;
  info.speed_cdeg_s = maneuver.speed_cdeg_s;
  info.crc = maneuver.crc();
  info.end_us = maneuver.end_us();
  info.generation = store.generation();
  return send(info, reply);
}

Reply RequestServer::maneuver_read(const uint8_t* payload, size_t size, uint8_t* reply) {
  ManeuverReadRequest request;
  if (!request.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  const Maneuver& maneuver = sequencer_.maneuvers().current();
  if (request.index >= maneuver.stroke_count) {
    return Reply::refused(ErrorCode::kIndexOutOfRange, request.index);
  }
  const Stroke& stroke = maneuver.strokes[request.index];
  ManeuverReadReply answer;
  answer.index = request.index;
  answer.joint = stroke.joint;
  answer.angle_cdeg = stroke.angle_cdeg;
  answer.start_us = stroke.start_us;
  return send(answer, reply);
}

Reply RequestServer::settings_write(const uint8_t* payload, size_t size, uint8_t* reply) {
  Settings wanted;
  if (!wanted.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  if (!sequencer_.may_upload()) return Reply::refused(ErrorCode::kWrongState);
  const int8_t defect = wanted.find_defect();
  if (defect >= 0) return Reply::refused(ErrorCode::kSettingOutOfRange, defect);
  SlotPair& store = sequencer_.settings();
  if (memcmp(store.staged(), payload, size) != 0) {
    if (store.writing()) return Reply::refused(ErrorCode::kWrongState);
    memcpy(store.staged(), payload, size);
    store.forget_last();
    settings_written_ = false;
  }
  return store_staged(store, settings_written_, reply);
}

Reply RequestServer::settings_read(uint8_t* reply) {
  const Stored<Settings>& store = sequencer_.settings();
  SettingsReadReply answer;
  answer.origin = store.origin();
  answer.generation = store.generation();
  answer.frame_us = store.current().frame_us;
  for (uint8_t i = 0; i < kJointCount; ++i) answer.servo[i] = store.current().servo[i];
  answer.moving_at_once = store.current().moving_at_once;
  return send(answer, reply);
}

Reply RequestServer::joint_report(const uint8_t* payload, size_t size, uint8_t* reply) {
  JointReportRequest request;
  if (!request.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  JointReportReply answer;
  answer.at_start_pose = sequencer_.report_joints(request.angle_cdeg) ? 1 : 0;
  return send(answer, reply);
}

Reply RequestServer::jog(const uint8_t* payload, size_t size, uint8_t* reply) {
  JogRequest request;
  if (!request.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  const ErrorCode refusal = sequencer_.jog(request);
  if (refusal != ErrorCode::kNone) return Reply::refused(refusal, request.joint);
  JogReply answer;
  answer.angle_cdeg = sequencer_.jogging().angle_cdeg();
  answer.arrived = sequencer_.jogging().arrived() ? 1 : 0;
  return send(answer, reply);
}

Reply RequestServer::arm(const uint8_t* payload, size_t size, uint8_t* reply) {
  ArmRequest request;
  if (!request.decode(payload, size)) return Reply::refused(ErrorCode::kBadLength);
  const ErrorCode refusal = sequencer_.arm(request.arm_token, now_);
  if (refusal != ErrorCode::kNone) return Reply::refused(refusal, sequencer_.switches_open());
  ArmReply answer;
  answer.state = sequencer_.state();
  return send(answer, reply);
}

Reply RequestServer::disarm(uint8_t* reply) {
  sequencer_.disarm();
  DisarmReply answer;
  answer.state = sequencer_.state();
  return send(answer, reply);
}

}  // namespace sequencer
}  // namespace tfsat

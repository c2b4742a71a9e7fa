// Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
//
// Include messages.h and frame.h of a sketch first.
#pragma once

namespace tfsat {
namespace golden {

struct Vector {
  const char* name;
  uint8_t type;
  uint8_t sequence;
  size_t (*build)(uint8_t* payload);
  bool (*matches)(const uint8_t* payload, size_t size);
  const uint8_t* payload;
  size_t payload_size;
  const uint8_t* frame;
  size_t frame_size;
};

inline size_t build_HelloRequest(uint8_t* payload) {
  (void)payload;
  return protocol::HelloRequest::kSize;
}

inline bool matches_HelloRequest(const uint8_t* payload, size_t size) {
  (void)payload;
  if (size != 0) return false;
  return true;
}

static const uint8_t kPayloadHelloRequest[] = {0};
static const uint8_t kFrameHelloRequest[] = {0x02, 0x01, 0x03, 0x3E, 0x2E, 0x00};

inline size_t build_HelloReply(uint8_t* payload) {
  protocol::HelloReply message;
  message.board = protocol::Board::kLogger;
  message.firmware_version[0] = 61u;
  message.firmware_version[1] = 219u;
  message.firmware_version[2] = 122u;
  message.board_serial[0] = 24u;
  message.board_serial[1] = 182u;
  message.board_serial[2] = 84u;
  message.board_serial[3] = 242u;
  message.board_serial[4] = 145u;
  message.board_serial[5] = 47u;
  message.board_serial[6] = 205u;
  message.board_serial[7] = 107u;
  message.image_crc = 167015379u;
  message.protocol_hash[0] = 168u;
  message.protocol_hash[1] = 70u;
  message.protocol_hash[2] = 228u;
  message.protocol_hash[3] = 130u;
  message.protocol_hash[4] = 33u;
  message.protocol_hash[5] = 191u;
  message.protocol_hash[6] = 93u;
  message.protocol_hash[7] = 251u;
  message.encode(payload);
  return protocol::HelloReply::kSize;
}

inline bool matches_HelloReply(const uint8_t* payload, size_t size) {
  protocol::HelloReply message;
  if (!message.decode(payload, size)) return false;
  return message.board == protocol::Board::kLogger && message.firmware_version[0] == 61u && message.firmware_version[1] == 219u && message.firmware_version[2] == 122u && message.board_serial[0] == 24u && message.board_serial[1] == 182u && message.board_serial[2] == 84u && message.board_serial[3] == 242u && message.board_serial[4] == 145u && message.board_serial[5] == 47u && message.board_serial[6] == 205u && message.board_serial[7] == 107u && message.image_crc == 167015379u && message.protocol_hash[0] == 168u && message.protocol_hash[1] == 70u && message.protocol_hash[2] == 228u && message.protocol_hash[3] == 130u && message.protocol_hash[4] == 33u && message.protocol_hash[5] == 191u && message.protocol_hash[6] == 93u && message.protocol_hash[7] == 251u;
}

static const uint8_t kPayloadHelloReply[] = {0x02, 0x3D, 0xDB, 0x7A, 0x18, 0xB6, 0x54, 0xF2, 0x91, 0x2F, 0xCD, 0x6B, 0xD3, 0x73, 0xF4, 0x09, 0xA8, 0x46, 0xE4, 0x82, 0x21, 0xBF, 0x5D, 0xFB};
static const uint8_t kFrameHelloReply[] = {0x1D, 0x81, 0x01, 0x02, 0x3D, 0xDB, 0x7A, 0x18, 0xB6, 0x54, 0xF2, 0x91, 0x2F, 0xCD, 0x6B, 0xD3, 0x73, 0xF4, 0x09, 0xA8, 0x46, 0xE4, 0x82, 0x21, 0xBF, 0x5D, 0xFB, 0x81, 0xCB, 0x00};

inline size_t build_SequencerStatusRequest(uint8_t* payload) {
  (void)payload;
  return protocol::SequencerStatusRequest::kSize;
}

inline bool matches_SequencerStatusRequest(const uint8_t* payload, size_t size) {
  (void)payload;
  if (size != 0) return false;
  return true;
}

static const uint8_t kPayloadSequencerStatusRequest[] = {0};
static const uint8_t kFrameSequencerStatusRequest[] = {0x05, 0x02, 0x02, 0x2F, 0x5B, 0x00};

inline size_t build_SequencerStatusReply(uint8_t* payload) {
  protocol::SequencerStatusReply message;
  message.state = protocol::SequencerState::kFault;
  message.fault = protocol::ErrorCode::kResetWhileRunning;
  message.last_refusal = protocol::ErrorCode::kJogNotConfirmed;
  message.switches_open = 116u;
  message.arm_token = 4805u;
  message.reset_cause = protocol::ResetCause::kBrownOut;
  message.resets_while_armed = 79u;
  message.strokes_started = 237u;
  message.knocks = 35747u;
  message.joint_angle_cdeg[0] = 10715;
  message.joint_angle_cdeg[1] = -14318;
  message.joint_angle_cdeg[2] = 26185;
  message.uptime_ms = 75591690u;
  message.image_crc = 2730027459u;
  message.ram_never_used_bytes = 16624u;
  message.frames_rejected = 57127u;
  message.stores_damaged = 125u;
  message.false_releases = 7062u;
  message.servos_driven = 185u;
  message.brown_out_level = 88u;
  message.encode(payload);
  return protocol::SequencerStatusReply::kSize;
}

inline bool matches_SequencerStatusReply(const uint8_t* payload, size_t size) {
  protocol::SequencerStatusReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kFault && message.fault == protocol::ErrorCode::kResetWhileRunning && message.last_refusal == protocol::ErrorCode::kJogNotConfirmed && message.switches_open == 116u && message.arm_token == 4805u && message.reset_cause == protocol::ResetCause::kBrownOut && message.resets_while_armed == 79u && message.strokes_started == 237u && message.knocks == 35747u && message.joint_angle_cdeg[0] == 10715 && message.joint_angle_cdeg[1] == -14318 && message.joint_angle_cdeg[2] == 26185 && message.uptime_ms == 75591690u && message.image_crc == 2730027459u && message.ram_never_used_bytes == 16624u && message.frames_rejected == 57127u && message.stores_damaged == 125u && message.false_releases == 7062u && message.servos_driven == 185u && message.brown_out_level == 88u;
}

static const uint8_t kPayloadSequencerStatusReply[] = {0x04, 0x17, 0x18, 0x74, 0xC5, 0x12, 0x02, 0x4F, 0xED, 0xA3, 0x8B, 0xDB, 0x29, 0x12, 0xC8, 0x49, 0x66, 0x0A, 0x70, 0x81, 0x04, 0xC3, 0xE9, 0xB8, 0xA2, 0xF0, 0x40, 0x27, 0xDF, 0x7D, 0x96, 0x1B, 0xB9, 0x58};
static const uint8_t kFrameSequencerStatusReply[] = {0x27, 0x82, 0x03, 0x04, 0x17, 0x18, 0x74, 0xC5, 0x12, 0x02, 0x4F, 0xED, 0xA3, 0x8B, 0xDB, 0x29, 0x12, 0xC8, 0x49, 0x66, 0x0A, 0x70, 0x81, 0x04, 0xC3, 0xE9, 0xB8, 0xA2, 0xF0, 0x40, 0x27, 0xDF, 0x7D, 0x96, 0x1B, 0xB9, 0x58, 0xCF, 0xA9, 0x00};

inline size_t build_RunReportRequest(uint8_t* payload) {
  (void)payload;
  return protocol::RunReportRequest::kSize;
}

inline bool matches_RunReportRequest(const uint8_t* payload, size_t size) {
  (void)payload;
  if (size != 0) return false;
  return true;
}

static const uint8_t kPayloadRunReportRequest[] = {0};
static const uint8_t kFrameRunReportRequest[] = {0x05, 0x04, 0x04, 0x4F, 0x91, 0x00};

inline size_t build_RunReportReply(uint8_t* payload) {
  protocol::RunReportReply message;
  message.released = 246u;
  message.bounces = 38004u;
  message.release_ms = 850145609u;
  message.release_us = 53475u;
  message.stroke_count = 111u;
  message.start_us[0] = 223518325u;
  message.start_us[1] = 2877954095u;
  message.start_us[2] = 1237422568u;
  message.start_us[3] = 3891858338u;
  message.start_us[4] = 2251326811u;
  message.start_us[5] = 610795285u;
  message.start_us[6] = 3265231054u;
  message.start_us[7] = 1624699528u;
  message.start_us[8] = 4279135297u;
  message.start_us[9] = 2638603771u;
  message.start_us[10] = 998072244u;
  message.start_us[11] = 3652508014u;
  message.start_us[12] = 2011976487u;
  message.start_us[13] = 371444961u;
  message.start_us[14] = 3025880730u;
  message.start_us[15] = 1385349204u;
  message.earlier_us = 4039784973u;
  message.later_us = 2399253447u;
  message.encode(payload);
  return protocol::RunReportReply::kSize;
}

inline bool matches_RunReportReply(const uint8_t* payload, size_t size) {
  protocol::RunReportReply message;
  if (!message.decode(payload, size)) return false;
  return message.released == 246u && message.bounces == 38004u && message.release_ms == 850145609u && message.release_us == 53475u && message.stroke_count == 111u && message.start_us[0] == 223518325u && message.start_us[1] == 2877954095u && message.start_us[2] == 1237422568u && message.start_us[3] == 3891858338u && message.start_us[4] == 2251326811u && message.start_us[5] == 610795285u && message.start_us[6] == 3265231054u && message.start_us[7] == 1624699528u && message.start_us[8] == 4279135297u && message.start_us[9] == 2638603771u && message.start_us[10] == 998072244u && message.start_us[11] == 3652508014u && message.start_us[12] == 2011976487u && message.start_us[13] == 371444961u && message.start_us[14] == 3025880730u && message.start_us[15] == 1385349204u && message.earlier_us == 4039784973u && message.later_us == 2399253447u;
}

static const uint8_t kPayloadRunReportReply[] = {0xF6, 0x74, 0x94, 0x49, 0x31, 0xAC, 0x32, 0xE3, 0xD0, 0x6F, 0x75, 0x9E, 0x52, 0x0D, 0x2F, 0x18, 0x8A, 0xAB, 0xE8, 0x91, 0xC1, 0x49, 0xA2, 0x0B, 0xF9, 0xE7, 0x5B, 0x85, 0x30, 0x86, 0x15, 0xFF, 0x67, 0x24, 0xCE, 0x78, 0x9F, 0xC2, 0x88, 0xF2, 0xD6, 0x60, 0x41, 0x6C, 0x0E, 0xFF, 0xFB, 0xE5, 0x45, 0x9D, 0xB4, 0x5F, 0x7D, 0x3B, 0x6E, 0xD9, 0xB4, 0xD9, 0x27, 0x53, 0xEC, 0x77, 0xE1, 0xCC, 0x23, 0x16, 0x9A, 0x46, 0x5B, 0xB4, 0x54, 0xC0, 0x92, 0x52, 0x0D, 0x3A, 0xCA, 0xF0, 0xC7, 0xB3, 0x01, 0x8F};
static const uint8_t kFrameRunReportReply[] = {0x57, 0x84, 0x05, 0xF6, 0x74, 0x94, 0x49, 0x31, 0xAC, 0x32, 0xE3, 0xD0, 0x6F, 0x75, 0x9E, 0x52, 0x0D, 0x2F, 0x18, 0x8A, 0xAB, 0xE8, 0x91, 0xC1, 0x49, 0xA2, 0x0B, 0xF9, 0xE7, 0x5B, 0x85, 0x30, 0x86, 0x15, 0xFF, 0x67, 0x24, 0xCE, 0x78, 0x9F, 0xC2, 0x88, 0xF2, 0xD6, 0x60, 0x41, 0x6C, 0x0E, 0xFF, 0xFB, 0xE5, 0x45, 0x9D, 0xB4, 0x5F, 0x7D, 0x3B, 0x6E, 0xD9, 0xB4, 0xD9, 0x27, 0x53, 0xEC, 0x77, 0xE1, 0xCC, 0x23, 0x16, 0x9A, 0x46, 0x5B, 0xB4, 0x54, 0xC0, 0x92, 0x52, 0x0D, 0x3A, 0xCA, 0xF0, 0xC7, 0xB3, 0x01, 0x8F, 0x07, 0xF9, 0x00};

inline size_t build_LoggerStatusRequest(uint8_t* payload) {
  (void)payload;
  return protocol::LoggerStatusRequest::kSize;
}

inline bool matches_LoggerStatusRequest(const uint8_t* payload, size_t size) {
  (void)payload;
  if (size != 0) return false;
  return true;
}

static const uint8_t kPayloadLoggerStatusRequest[] = {0};
static const uint8_t kFrameLoggerStatusRequest[] = {0x05, 0x03, 0x06, 0x9A, 0x28, 0x00};

inline size_t build_LoggerStatusReply(uint8_t* payload) {
  protocol::LoggerStatusReply message;
  message.state = protocol::LoggerState::kIdle;
  message.error = protocol::ErrorCode::kNoManeuver;
  message.imu_present = 105u;
  message.switches_open = 7u;
  message.session = 2786530406u;
  message.samples = 1145998880u;
  message.samples_dropped = 3800434649u;
  message.blocks_written = 2159903123u;
  message.ring_blocks = 7924u;
  message.ring_peak_blocks = 48428u;
  message.rate_hz = 23395u;
  message.who_am_i[0] = 249u;
  message.who_am_i[1] = 151u;
  message.who_am_i[2] = 54u;
  message.who_am_i[3] = 212u;
  message.uptime_ms = 1920552799u;
  message.card = protocol::CardState::kFull;
  message.card_free_mib = 2934457042u;
  message.phase = protocol::DropPhase::kLanded;
  message.ram_holds_drop = 235u;
  message.late_ticks = 2307829758u;
  message.settings_origin = protocol::Origin::kFactory;
  message.unix_us = 14266738903728519442ull;
  message.maneuver_known = 100u;
  message.maneuver_crc = 620u;
  message.encode(payload);
  return protocol::LoggerStatusReply::kSize;
}

inline bool matches_LoggerStatusReply(const uint8_t* payload, size_t size) {
  protocol::LoggerStatusReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kIdle && message.error == protocol::ErrorCode::kNoManeuver && message.imu_present == 105u && message.switches_open == 7u && message.session == 2786530406u && message.samples == 1145998880u && message.samples_dropped == 3800434649u && message.blocks_written == 2159903123u && message.ring_blocks == 7924u && message.ring_peak_blocks == 48428u && message.rate_hz == 23395u && message.who_am_i[0] == 249u && message.who_am_i[1] == 151u && message.who_am_i[2] == 54u && message.who_am_i[3] == 212u && message.uptime_ms == 1920552799u && message.card == protocol::CardState::kFull && message.card_free_mib == 2934457042u && message.phase == protocol::DropPhase::kLanded && message.ram_holds_drop == 235u && message.late_ticks == 2307829758u && message.settings_origin == protocol::Origin::kFactory && message.unix_us == 14266738903728519442ull && message.maneuver_known == 100u && message.maneuver_crc == 620u;
}

static const uint8_t kPayloadLoggerStatusReply[] = {0x00, 0x10, 0x69, 0x07, 0x66, 0x14, 0x17, 0xA6, 0x20, 0x8E, 0x4E, 0x44, 0xD9, 0x07, 0x86, 0xE2, 0x93, 0x81, 0xBD, 0x80, 0xF4, 0x1E, 0x2C, 0xBD, 0x63, 0x5B, 0xF9, 0x97, 0x36, 0xD4, 0x5F, 0x4F, 0x79, 0x72, 0x04, 0xD2, 0x42, 0xE8, 0xAE, 0x02, 0xEB, 0xFE, 0xAF, 0x8E, 0x89, 0x00, 0x12, 0xF9, 0xFB, 0xCB, 0x71, 0xA3, 0xFD, 0xC5, 0x64, 0x6C, 0x02};
static const uint8_t kFrameLoggerStatusReply[] = {0x03, 0x83, 0x07, 0x2D, 0x10, 0x69, 0x07, 0x66, 0x14, 0x17, 0xA6, 0x20, 0x8E, 0x4E, 0x44, 0xD9, 0x07, 0x86, 0xE2, 0x93, 0x81, 0xBD, 0x80, 0xF4, 0x1E, 0x2C, 0xBD, 0x63, 0x5B, 0xF9, 0x97, 0x36, 0xD4, 0x5F, 0x4F, 0x79, 0x72, 0x04, 0xD2, 0x42, 0xE8, 0xAE, 0x02, 0xEB, 0xFE, 0xAF, 0x8E, 0x89, 0x0E, 0x12, 0xF9, 0xFB, 0xCB, 0x71, 0xA3, 0xFD, 0xC5, 0x64, 0x6C, 0x02, 0xBD, 0xB6, 0x00};

inline size_t build_ManeuverBeginRequest(uint8_t* payload) {
  protocol::ManeuverBeginRequest message;
  message.stroke_count = 160u;
  message.speed_cdeg_s = 16091u;
  message.encode(payload);
  return protocol::ManeuverBeginRequest::kSize;
}

inline bool matches_ManeuverBeginRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverBeginRequest message;
  if (!message.decode(payload, size)) return false;
  return message.stroke_count == 160u && message.speed_cdeg_s == 16091u;
}

static const uint8_t kPayloadManeuverBeginRequest[] = {0xA0, 0xDB, 0x3E};
static const uint8_t kFrameManeuverBeginRequest[] = {0x08, 0x10, 0x08, 0xA0, 0xDB, 0x3E, 0x49, 0x33, 0x00};

inline size_t build_ManeuverBeginReply(uint8_t* payload) {
  protocol::ManeuverBeginReply message;
  message.stroke_count = 221u;
  message.encode(payload);
  return protocol::ManeuverBeginReply::kSize;
}

inline bool matches_ManeuverBeginReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverBeginReply message;
  if (!message.decode(payload, size)) return false;
  return message.stroke_count == 221u;
}

static const uint8_t kPayloadManeuverBeginReply[] = {0xDD};
static const uint8_t kFrameManeuverBeginReply[] = {0x06, 0x90, 0x09, 0xDD, 0xED, 0x14, 0x00};

inline size_t build_ManeuverStrokeRequest(uint8_t* payload) {
  protocol::ManeuverStrokeRequest message;
  message.index = 123u;
  message.joint = 25u;
  message.angle_cdeg = -18503;
  message.start_us = 1441852151u;
  message.encode(payload);
  return protocol::ManeuverStrokeRequest::kSize;
}

inline bool matches_ManeuverStrokeRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverStrokeRequest message;
  if (!message.decode(payload, size)) return false;
  return message.index == 123u && message.joint == 25u && message.angle_cdeg == -18503 && message.start_us == 1441852151u;
}

static const uint8_t kPayloadManeuverStrokeRequest[] = {0x7B, 0x19, 0xB9, 0xB7, 0xF7, 0xEA, 0xF0, 0x55};
static const uint8_t kFrameManeuverStrokeRequest[] = {0x0D, 0x11, 0x0A, 0x7B, 0x19, 0xB9, 0xB7, 0xF7, 0xEA, 0xF0, 0x55, 0xC3, 0xC5, 0x00};

inline size_t build_ManeuverStrokeReply(uint8_t* payload) {
  protocol::ManeuverStrokeReply message;
  message.index = 244u;
  message.encode(payload);
  return protocol::ManeuverStrokeReply::kSize;
}

inline bool matches_ManeuverStrokeReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverStrokeReply message;
  if (!message.decode(payload, size)) return false;
  return message.index == 244u;
}

static const uint8_t kPayloadManeuverStrokeReply[] = {0xF4};
static const uint8_t kFrameManeuverStrokeReply[] = {0x06, 0x91, 0x0B, 0xF4, 0xF4, 0xF0, 0x00};

inline size_t build_ManeuverCommitRequest(uint8_t* payload) {
  protocol::ManeuverCommitRequest message;
  message.crc = 37471u;
  message.encode(payload);
  return protocol::ManeuverCommitRequest::kSize;
}

inline bool matches_ManeuverCommitRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverCommitRequest message;
  if (!message.decode(payload, size)) return false;
  return message.crc == 37471u;
}

static const uint8_t kPayloadManeuverCommitRequest[] = {0x5F, 0x92};
static const uint8_t kFrameManeuverCommitRequest[] = {0x07, 0x12, 0x0C, 0x5F, 0x92, 0x14, 0xBA, 0x00};

inline size_t build_ManeuverCommitReply(uint8_t* payload) {
  protocol::ManeuverCommitReply message;
  message.stored = 48u;
  message.written = 206u;
  message.encode(payload);
  return protocol::ManeuverCommitReply::kSize;
}

inline bool matches_ManeuverCommitReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverCommitReply message;
  if (!message.decode(payload, size)) return false;
  return message.stored == 48u && message.written == 206u;
}

static const uint8_t kPayloadManeuverCommitReply[] = {0x30, 0xCE};
static const uint8_t kFrameManeuverCommitReply[] = {0x07, 0x92, 0x0D, 0x30, 0xCE, 0x71, 0xD0, 0x00};

inline size_t build_ManeuverInfoRequest(uint8_t* payload) {
  (void)payload;
  return protocol::ManeuverInfoRequest::kSize;
}

inline bool matches_ManeuverInfoRequest(const uint8_t* payload, size_t size) {
  (void)payload;
  if (size != 0) return false;
  return true;
}

static const uint8_t kPayloadManeuverInfoRequest[] = {0};
static const uint8_t kFrameManeuverInfoRequest[] = {0x05, 0x13, 0x0E, 0xE1, 0xAA, 0x00};

inline size_t build_ManeuverInfoReply(uint8_t* payload) {
  protocol::ManeuverInfoReply message;
  message.origin = protocol::Origin::kUploaded;
  message.stroke_count = 11u;
  message.speed_cdeg_s = 43381u;
  message.crc = 18348u;
  message.end_us = 3856937596u;
  message.generation = 2216406070u;
  message.encode(payload);
  return protocol::ManeuverInfoReply::kSize;
}

inline bool matches_ManeuverInfoReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverInfoReply message;
  if (!message.decode(payload, size)) return false;
  return message.origin == protocol::Origin::kUploaded && message.stroke_count == 11u && message.speed_cdeg_s == 43381u && message.crc == 18348u && message.end_us == 3856937596u && message.generation == 2216406070u;
}

static const uint8_t kPayloadManeuverInfoReply[] = {0x01, 0x0B, 0x75, 0xA9, 0xAC, 0x47, 0x7C, 0x32, 0xE4, 0xE5, 0x36, 0xAC, 0x1B, 0x84};
static const uint8_t kFrameManeuverInfoReply[] = {0x13, 0x93, 0x0F, 0x01, 0x0B, 0x75, 0xA9, 0xAC, 0x47, 0x7C, 0x32, 0xE4, 0xE5, 0x36, 0xAC, 0x1B, 0x84, 0x5C, 0x8E, 0x00};

inline size_t build_ManeuverReadRequest(uint8_t* payload) {
  protocol::ManeuverReadRequest message;
  message.index = 34u;
  message.encode(payload);
  return protocol::ManeuverReadRequest::kSize;
}

inline bool matches_ManeuverReadRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverReadRequest message;
  if (!message.decode(payload, size)) return false;
  return message.index == 34u;
}

static const uint8_t kPayloadManeuverReadRequest[] = {0x22};
static const uint8_t kFrameManeuverReadRequest[] = {0x06, 0x14, 0x10, 0x22, 0x6C, 0x54, 0x00};

inline size_t build_ManeuverReadReply(uint8_t* payload) {
  protocol::ManeuverReadReply message;
  message.index = 192u;
  message.joint = 94u;
  message.angle_cdeg = -775;
  message.start_us = 2603683029u;
  message.encode(payload);
  return protocol::ManeuverReadReply::kSize;
}

inline bool matches_ManeuverReadReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.index == 192u && message.joint == 94u && message.angle_cdeg == -775 && message.start_us == 2603683029u;
}

static const uint8_t kPayloadManeuverReadReply[] = {0xC0, 0x5E, 0xF9, 0xFC, 0xD5, 0x0C, 0x31, 0x9B};
static const uint8_t kFrameManeuverReadReply[] = {0x0D, 0x94, 0x11, 0xC0, 0x5E, 0xF9, 0xFC, 0xD5, 0x0C, 0x31, 0x9B, 0x4F, 0x5F, 0x00};

inline size_t build_ArmRequest(uint8_t* payload) {
  protocol::ArmRequest message;
  message.arm_token = 14696u;
  message.encode(payload);
  return protocol::ArmRequest::kSize;
}

inline bool matches_ArmRequest(const uint8_t* payload, size_t size) {
  protocol::ArmRequest message;
  if (!message.decode(payload, size)) return false;
  return message.arm_token == 14696u;
}

static const uint8_t kPayloadArmRequest[] = {0x68, 0x39};
static const uint8_t kFrameArmRequest[] = {0x07, 0x20, 0x12, 0x68, 0x39, 0x74, 0xBB, 0x00};

inline size_t build_ArmReply(uint8_t* payload) {
  protocol::ArmReply message;
  message.state = protocol::SequencerState::kJogging;
  message.encode(payload);
  return protocol::ArmReply::kSize;
}

inline bool matches_ArmReply(const uint8_t* payload, size_t size) {
  protocol::ArmReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kJogging;
}

static const uint8_t kPayloadArmReply[] = {0x05};
static const uint8_t kFrameArmReply[] = {0x06, 0xA0, 0x13, 0x05, 0x85, 0x77, 0x00};

inline size_t build_DisarmRequest(uint8_t* payload) {
  (void)payload;
  return protocol::DisarmRequest::kSize;
}

inline bool matches_DisarmRequest(const uint8_t* payload, size_t size) {
  (void)payload;
  if (size != 0) return false;
  return true;
}

static const uint8_t kPayloadDisarmRequest[] = {0};
static const uint8_t kFrameDisarmRequest[] = {0x05, 0x21, 0x14, 0x6D, 0x7A, 0x00};

inline size_t build_DisarmReply(uint8_t* payload) {
  protocol::DisarmReply message;
  message.state = protocol::SequencerState::kSafe;
  message.encode(payload);
  return protocol::DisarmReply::kSize;
}

inline bool matches_DisarmReply(const uint8_t* payload, size_t size) {
  protocol::DisarmReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kSafe;
}

static const uint8_t kPayloadDisarmReply[] = {0x00};
static const uint8_t kFrameDisarmReply[] = {0x03, 0xA1, 0x15, 0x03, 0xB6, 0xBA, 0x00};

inline size_t build_RecordStartRequest(uint8_t* payload) {
  protocol::RecordStartRequest message;
  message.number = 336524219u;
  message.unix_us = 12846075337329346419ull;
  message.maneuver_known = 80u;
  message.maneuver_crc = 61109u;
  message.encode(payload);
  return protocol::RecordStartRequest::kSize;
}

inline bool matches_RecordStartRequest(const uint8_t* payload, size_t size) {
  protocol::RecordStartRequest message;
  if (!message.decode(payload, size)) return false;
  return message.number == 336524219u && message.unix_us == 12846075337329346419ull && message.maneuver_known == 80u && message.maneuver_crc == 61109u;
}

static const uint8_t kPayloadRecordStartRequest[] = {0xBB, 0xF3, 0x0E, 0x14, 0x73, 0x07, 0x6C, 0x37, 0x75, 0x6D, 0x46, 0xB2, 0x50, 0xB5, 0xEE};
static const uint8_t kFrameRecordStartRequest[] = {0x14, 0x40, 0x16, 0xBB, 0xF3, 0x0E, 0x14, 0x73, 0x07, 0x6C, 0x37, 0x75, 0x6D, 0x46, 0xB2, 0x50, 0xB5, 0xEE, 0x26, 0x97, 0x00};

inline size_t build_RecordStartReply(uint8_t* payload) {
  protocol::RecordStartReply message;
  message.state = protocol::LoggerState::kFailed;
  message.session = 723801179u;
  message.encode(payload);
  return protocol::RecordStartReply::kSize;
}

inline bool matches_RecordStartReply(const uint8_t* payload, size_t size) {
  protocol::RecordStartReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kFailed && message.session == 723801179u;
}

static const uint8_t kPayloadRecordStartReply[] = {0x04, 0x5B, 0x54, 0x24, 0x2B};
static const uint8_t kFrameRecordStartReply[] = {0x0A, 0xC0, 0x17, 0x04, 0x5B, 0x54, 0x24, 0x2B, 0x19, 0x6A, 0x00};

inline size_t build_RecordStopRequest(uint8_t* payload) {
  (void)payload;
  return protocol::RecordStopRequest::kSize;
}

inline bool matches_RecordStopRequest(const uint8_t* payload, size_t size) {
  (void)payload;
  if (size != 0) return false;
  return true;
}

static const uint8_t kPayloadRecordStopRequest[] = {0};
static const uint8_t kFrameRecordStopRequest[] = {0x05, 0x41, 0x18, 0xCB, 0xB0, 0x00};

inline size_t build_RecordStopReply(uint8_t* payload) {
  protocol::RecordStopReply message;
  message.state = protocol::LoggerState::kRecording;
  message.session = 1737705422u;
  message.samples = 97173895u;
  message.samples_dropped = 2751609665u;
  message.encode(payload);
  return protocol::RecordStopReply::kSize;
}

inline bool matches_RecordStopReply(const uint8_t* payload, size_t size) {
  protocol::RecordStopReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kRecording && message.session == 1737705422u && message.samples == 97173895u && message.samples_dropped == 2751609665u;
}

static const uint8_t kPayloadRecordStopReply[] = {0x01, 0xCE, 0x47, 0x93, 0x67, 0x87, 0xC1, 0xCA, 0x05, 0x41, 0x3B, 0x02, 0xA4};
static const uint8_t kFrameRecordStopReply[] = {0x12, 0xC1, 0x19, 0x01, 0xCE, 0x47, 0x93, 0x67, 0x87, 0xC1, 0xCA, 0x05, 0x41, 0x3B, 0x02, 0xA4, 0xBE, 0x5E, 0x00};

inline size_t build_LiveRequest(uint8_t* payload) {
  protocol::LiveRequest message;
  message.enabled = 66u;
  message.encode(payload);
  return protocol::LiveRequest::kSize;
}

inline bool matches_LiveRequest(const uint8_t* payload, size_t size) {
  protocol::LiveRequest message;
  if (!message.decode(payload, size)) return false;
  return message.enabled == 66u;
}

static const uint8_t kPayloadLiveRequest[] = {0x42};
static const uint8_t kFrameLiveRequest[] = {0x06, 0x42, 0x1A, 0x42, 0x6F, 0x3B, 0x00};

inline size_t build_LiveReply(uint8_t* payload) {
  protocol::LiveReply message;
  message.enabled = 224u;
  message.rate_hz = 32424u;
  message.gyro_lsb_per_deg_s = 134.9375f;
  message.accel_lsb_per_g = 72.25f;
  message.angle_counts_per_turn = 1498355098u;
  message.dlpf_cfg = 247u;
  message.who_am_i[0] = 149u;
  message.who_am_i[1] = 51u;
  message.who_am_i[2] = 210u;
  message.who_am_i[3] = 112u;
  message.imu_offset_us[0] = 3739u;
  message.imu_offset_us[1] = 44243u;
  message.imu_offset_us[2] = 19210u;
  message.imu_offset_us[3] = 59714u;
  message.angle_offset_us[0] = 34681u;
  message.angle_offset_us[1] = 9649u;
  message.angle_offset_us[2] = 50152u;
  message.angle_offset_us[3] = 25120u;
  message.angle_offset_us[4] = 87u;
  message.angle_offset_us[5] = 40591u;
  message.encode(payload);
  return protocol::LiveReply::kSize;
}

inline bool matches_LiveReply(const uint8_t* payload, size_t size) {
  protocol::LiveReply message;
  if (!message.decode(payload, size)) return false;
  return message.enabled == 224u && message.rate_hz == 32424u && message.gyro_lsb_per_deg_s == 134.9375f && message.accel_lsb_per_g == 72.25f && message.angle_counts_per_turn == 1498355098u && message.dlpf_cfg == 247u && message.who_am_i[0] == 149u && message.who_am_i[1] == 51u && message.who_am_i[2] == 210u && message.who_am_i[3] == 112u && message.imu_offset_us[0] == 3739u && message.imu_offset_us[1] == 44243u && message.imu_offset_us[2] == 19210u && message.imu_offset_us[3] == 59714u && message.angle_offset_us[0] == 34681u && message.angle_offset_us[1] == 9649u && message.angle_offset_us[2] == 50152u && message.angle_offset_us[3] == 25120u && message.angle_offset_us[4] == 87u && message.angle_offset_us[5] == 40591u;
}

static const uint8_t kPayloadLiveReply[] = {0xE0, 0xA8, 0x7E, 0x00, 0xF0, 0x06, 0x43, 0x00, 0x80, 0x90, 0x42, 0x9A, 0x15, 0x4F, 0x59, 0xF7, 0x95, 0x33, 0xD2, 0x70, 0x9B, 0x0E, 0xD3, 0xAC, 0x0A, 0x4B, 0x42, 0xE9, 0x79, 0x87, 0xB1, 0x25, 0xE8, 0xC3, 0x20, 0x62, 0x57, 0x00, 0x8F, 0x9E};
static const uint8_t kFrameLiveReply[] = {0x06, 0xC2, 0x1B, 0xE0, 0xA8, 0x7E, 0x04, 0xF0, 0x06, 0x43, 0x1E, 0x80, 0x90, 0x42, 0x9A, 0x15, 0x4F, 0x59, 0xF7, 0x95, 0x33, 0xD2, 0x70, 0x9B, 0x0E, 0xD3, 0xAC, 0x0A, 0x4B, 0x42, 0xE9, 0x79, 0x87, 0xB1, 0x25, 0xE8, 0xC3, 0x20, 0x62, 0x57, 0x05, 0x8F, 0x9E, 0x1B, 0x1D, 0x00};

inline size_t build_LoggerSettingsWriteRequest(uint8_t* payload) {
  protocol::LoggerSettingsWriteRequest message;
  message.settings.rate_hz = 56062u;
  message.settings.gyro_range_deg_s = 31029u;
  message.settings.accel_range_g = 23u;
  message.settings.dlpf_cfg = 181u;
  message.settings.bus_khz = 21468u;
  message.settings.after_landing_s = 61971u;
  message.settings.file_mib = 36939u;
  message.encode(payload);
  return protocol::LoggerSettingsWriteRequest::kSize;
}

inline bool matches_LoggerSettingsWriteRequest(const uint8_t* payload, size_t size) {
  protocol::LoggerSettingsWriteRequest message;
  if (!message.decode(payload, size)) return false;
  return message.settings.rate_hz == 56062u && message.settings.gyro_range_deg_s == 31029u && message.settings.accel_range_g == 23u && message.settings.dlpf_cfg == 181u && message.settings.bus_khz == 21468u && message.settings.after_landing_s == 61971u && message.settings.file_mib == 36939u;
}

static const uint8_t kPayloadLoggerSettingsWriteRequest[] = {0xFE, 0xDA, 0x35, 0x79, 0x17, 0xB5, 0xDC, 0x53, 0x13, 0xF2, 0x4B, 0x90};
static const uint8_t kFrameLoggerSettingsWriteRequest[] = {0x11, 0x45, 0x1C, 0xFE, 0xDA, 0x35, 0x79, 0x17, 0xB5, 0xDC, 0x53, 0x13, 0xF2, 0x4B, 0x90, 0x48, 0xC4, 0x00};

inline size_t build_LoggerSettingsWriteReply(uint8_t* payload) {
  protocol::LoggerSettingsWriteReply message;
  message.stored = 46u;
  message.encode(payload);
  return protocol::LoggerSettingsWriteReply::kSize;
}

inline bool matches_LoggerSettingsWriteReply(const uint8_t* payload, size_t size) {
  protocol::LoggerSettingsWriteReply message;
  if (!message.decode(payload, size)) return false;
  return message.stored == 46u;
}

static const uint8_t kPayloadLoggerSettingsWriteReply[] = {0x2E};
static const uint8_t kFrameLoggerSettingsWriteReply[] = {0x06, 0xC5, 0x1D, 0x2E, 0x18, 0xB1, 0x00};

inline size_t build_LoggerSettingsReadRequest(uint8_t* payload) {
  (void)payload;
  return protocol::LoggerSettingsReadRequest::kSize;
}

inline bool matches_LoggerSettingsReadRequest(const uint8_t* payload, size_t size) {
  (void)payload;
  if (size != 0) return false;
  return true;
}

static const uint8_t kPayloadLoggerSettingsReadRequest[] = {0};
static const uint8_t kFrameLoggerSettingsReadRequest[] = {0x05, 0x46, 0x1E, 0x9A, 0x49, 0x00};

inline size_t build_LoggerSettingsReadReply(uint8_t* payload) {
  protocol::LoggerSettingsReadReply message;
  message.origin = protocol::Origin::kUploaded;
  message.settings.rate_hz = 2344u;
  message.settings.gyro_range_deg_s = 42848u;
  message.settings.accel_range_g = 69u;
  message.settings.dlpf_cfg = 227u;
  message.settings.bus_khz = 33286u;
  message.settings.after_landing_s = 8254u;
  message.settings.file_mib = 48757u;
  message.rate_max_hz = 23725u;
  message.encode(payload);
  return protocol::LoggerSettingsReadReply::kSize;
}

inline bool matches_LoggerSettingsReadReply(const uint8_t* payload, size_t size) {
  protocol::LoggerSettingsReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.origin == protocol::Origin::kUploaded && message.settings.rate_hz == 2344u && message.settings.gyro_range_deg_s == 42848u && message.settings.accel_range_g == 69u && message.settings.dlpf_cfg == 227u && message.settings.bus_khz == 33286u && message.settings.after_landing_s == 8254u && message.settings.file_mib == 48757u && message.rate_max_hz == 23725u;
}

static const uint8_t kPayloadLoggerSettingsReadReply[] = {0x01, 0x28, 0x09, 0x60, 0xA7, 0x45, 0xE3, 0x06, 0x82, 0x3E, 0x20, 0x75, 0xBE, 0xAD, 0x5C};
static const uint8_t kFrameLoggerSettingsReadReply[] = {0x14, 0xC6, 0x1F, 0x01, 0x28, 0x09, 0x60, 0xA7, 0x45, 0xE3, 0x06, 0x82, 0x3E, 0x20, 0x75, 0xBE, 0xAD, 0x5C, 0x36, 0x85, 0x00};

inline size_t build_ClockSetRequest(uint8_t* payload) {
  protocol::ClockSetRequest message;
  message.unix_us = 18078779272879523704ull;
  message.encode(payload);
  return protocol::ClockSetRequest::kSize;
}

inline bool matches_ClockSetRequest(const uint8_t* payload, size_t size) {
  protocol::ClockSetRequest message;
  if (!message.decode(payload, size)) return false;
  return message.unix_us == 18078779272879523704ull;
}

static const uint8_t kPayloadClockSetRequest[] = {0x78, 0xC7, 0xAD, 0x94, 0xF6, 0xB9, 0xE4, 0xFA};
static const uint8_t kFrameClockSetRequest[] = {0x0D, 0x47, 0x20, 0x78, 0xC7, 0xAD, 0x94, 0xF6, 0xB9, 0xE4, 0xFA, 0xDC, 0xA3, 0x00};

inline size_t build_ClockSetReply(uint8_t* payload) {
  protocol::ClockSetReply message;
  message.uptime_us = 11032750018493170573ull;
  message.encode(payload);
  return protocol::ClockSetReply::kSize;
}

inline bool matches_ClockSetReply(const uint8_t* payload, size_t size) {
  protocol::ClockSetReply message;
  if (!message.decode(payload, size)) return false;
  return message.uptime_us == 11032750018493170573ull;
}

static const uint8_t kPayloadClockSetReply[] = {0x8D, 0x43, 0xF8, 0x13, 0xB0, 0x33, 0x1C, 0x99};
static const uint8_t kFrameClockSetReply[] = {0x0D, 0xC7, 0x21, 0x8D, 0x43, 0xF8, 0x13, 0xB0, 0x33, 0x1C, 0x99, 0x65, 0xC6, 0x00};

inline size_t build_LogListRequest(uint8_t* payload) {
  protocol::LogListRequest message;
  message.from_number = 14163u;
  message.encode(payload);
  return protocol::LogListRequest::kSize;
}

inline bool matches_LogListRequest(const uint8_t* payload, size_t size) {
  protocol::LogListRequest message;
  if (!message.decode(payload, size)) return false;
  return message.from_number == 14163u;
}

static const uint8_t kPayloadLogListRequest[] = {0x53, 0x37};
static const uint8_t kFrameLogListRequest[] = {0x07, 0x48, 0x22, 0x53, 0x37, 0x61, 0x9A, 0x00};

inline size_t build_LogListReply(uint8_t* payload) {
  protocol::LogListReply message;
  message.found = 213u;
  message.entry.number = 4602u;
  message.entry.session = 2956039247u;
  message.entry.blocks = 1315507721u;
  message.entry.wall_clock_us = 17050777458917353504ull;
  message.entry.closed = 138u;
  message.encode(payload);
  return protocol::LogListReply::kSize;
}

inline bool matches_LogListReply(const uint8_t* payload, size_t size) {
  protocol::LogListReply message;
  if (!message.decode(payload, size)) return false;
  return message.found == 213u && message.entry.number == 4602u && message.entry.session == 2956039247u && message.entry.blocks == 1315507721u && message.entry.wall_clock_us == 17050777458917353504ull && message.entry.closed == 138u;
}

static const uint8_t kPayloadLogListReply[] = {0xD5, 0xFA, 0x11, 0x4F, 0x94, 0x31, 0xB0, 0x09, 0x0E, 0x69, 0x4E, 0x20, 0xA8, 0x01, 0x8F, 0xC2, 0x87, 0xA0, 0xEC, 0x8A};
static const uint8_t kFrameLogListReply[] = {0x19, 0xC8, 0x23, 0xD5, 0xFA, 0x11, 0x4F, 0x94, 0x31, 0xB0, 0x09, 0x0E, 0x69, 0x4E, 0x20, 0xA8, 0x01, 0x8F, 0xC2, 0x87, 0xA0, 0xEC, 0x8A, 0x6B, 0xCC, 0x00};

inline size_t build_LogReadRequest(uint8_t* payload) {
  protocol::LogReadRequest message;
  message.number = 10511u;
  message.session = 3343316207u;
  message.first_block = 1702784680u;
  message.count = 949u;
  message.encode(payload);
  return protocol::LogReadRequest::kSize;
}

inline bool matches_LogReadRequest(const uint8_t* payload, size_t size) {
  protocol::LogReadRequest message;
  if (!message.decode(payload, size)) return false;
  return message.number == 10511u && message.session == 3343316207u && message.first_block == 1702784680u && message.count == 949u;
}

static const uint8_t kPayloadLogReadRequest[] = {0x0F, 0x29, 0xEF, 0xF4, 0x46, 0xC7, 0xA8, 0x6E, 0x7E, 0x65, 0xB5, 0x03};
static const uint8_t kFrameLogReadRequest[] = {0x11, 0x49, 0x24, 0x0F, 0x29, 0xEF, 0xF4, 0x46, 0xC7, 0xA8, 0x6E, 0x7E, 0x65, 0xB5, 0x03, 0x2B, 0xEA, 0x00};

inline size_t build_LogReadReply(uint8_t* payload) {
  protocol::LogReadReply message;
  message.count = 41453u;
  message.encode(payload);
  return protocol::LogReadReply::kSize;
}

inline bool matches_LogReadReply(const uint8_t* payload, size_t size) {
  protocol::LogReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.count == 41453u;
}

static const uint8_t kPayloadLogReadReply[] = {0xED, 0xA1};
static const uint8_t kFrameLogReadReply[] = {0x05, 0xC9, 0x25, 0xED, 0xA1, 0x02, 0x6A, 0x00};

inline size_t build_LogEraseRequest(uint8_t* payload) {
  protocol::LogEraseRequest message;
  message.number = 16420u;
  message.session = 3730593166u;
  message.encode(payload);
  return protocol::LogEraseRequest::kSize;
}

inline bool matches_LogEraseRequest(const uint8_t* payload, size_t size) {
  protocol::LogEraseRequest message;
  if (!message.decode(payload, size)) return false;
  return message.number == 16420u && message.session == 3730593166u;
}

static const uint8_t kPayloadLogEraseRequest[] = {0x24, 0x40, 0x8E, 0x55, 0x5C, 0xDE};
static const uint8_t kFrameLogEraseRequest[] = {0x0B, 0x4A, 0x26, 0x24, 0x40, 0x8E, 0x55, 0x5C, 0xDE, 0xBD, 0x10, 0x00};

inline size_t build_LogEraseReply(uint8_t* payload) {
  protocol::LogEraseReply message;
  message.erased = 124u;
  message.encode(payload);
  return protocol::LogEraseReply::kSize;
}

inline bool matches_LogEraseReply(const uint8_t* payload, size_t size) {
  protocol::LogEraseReply message;
  if (!message.decode(payload, size)) return false;
  return message.erased == 124u;
}

static const uint8_t kPayloadLogEraseReply[] = {0x7C};
static const uint8_t kFrameLogEraseReply[] = {0x06, 0xCA, 0x27, 0x7C, 0xC0, 0x0D, 0x00};

inline size_t build_LogPartStream(uint8_t* payload) {
  protocol::LogPartStream message;
  message.block = 449530113u;
  message.part = 185u;
  message.data[0] = 87u;
  message.data[1] = 245u;
  message.data[2] = 147u;
  message.data[3] = 49u;
  message.data[4] = 208u;
  message.data[5] = 110u;
  message.data[6] = 12u;
  message.data[7] = 170u;
  message.data[8] = 72u;
  message.data[9] = 231u;
  message.data[10] = 133u;
  message.data[11] = 35u;
  message.data[12] = 193u;
  message.data[13] = 96u;
  message.data[14] = 254u;
  message.data[15] = 156u;
  message.data[16] = 58u;
  message.data[17] = 216u;
  message.data[18] = 119u;
  message.data[19] = 21u;
  message.data[20] = 179u;
  message.data[21] = 81u;
  message.data[22] = 239u;
  message.data[23] = 142u;
  message.data[24] = 44u;
  message.data[25] = 202u;
  message.data[26] = 104u;
  message.data[27] = 7u;
  message.data[28] = 165u;
  message.data[29] = 67u;
  message.data[30] = 225u;
  message.data[31] = 127u;
  message.data[32] = 30u;
  message.data[33] = 188u;
  message.data[34] = 90u;
  message.data[35] = 248u;
  message.data[36] = 151u;
  message.data[37] = 53u;
  message.data[38] = 211u;
  message.data[39] = 113u;
  message.data[40] = 15u;
  message.data[41] = 174u;
  message.data[42] = 76u;
  message.data[43] = 234u;
  message.data[44] = 136u;
  message.data[45] = 38u;
  message.data[46] = 197u;
  message.data[47] = 99u;
  message.data[48] = 1u;
  message.data[49] = 159u;
  message.data[50] = 62u;
  message.data[51] = 220u;
  message.data[52] = 122u;
  message.data[53] = 24u;
  message.data[54] = 182u;
  message.data[55] = 85u;
  message.data[56] = 243u;
  message.data[57] = 145u;
  message.data[58] = 47u;
  message.data[59] = 206u;
  message.data[60] = 108u;
  message.data[61] = 10u;
  message.data[62] = 168u;
  message.data[63] = 70u;
  message.encode(payload);
  return protocol::LogPartStream::kSize;
}

inline bool matches_LogPartStream(const uint8_t* payload, size_t size) {
  protocol::LogPartStream message;
  if (!message.decode(payload, size)) return false;
  return message.block == 449530113u && message.part == 185u && message.data[0] == 87u && message.data[1] == 245u && message.data[2] == 147u && message.data[3] == 49u && message.data[4] == 208u && message.data[5] == 110u && message.data[6] == 12u && message.data[7] == 170u && message.data[8] == 72u && message.data[9] == 231u && message.data[10] == 133u && message.data[11] == 35u && message.data[12] == 193u && message.data[13] == 96u && message.data[14] == 254u && message.data[15] == 156u && message.data[16] == 58u && message.data[17] == 216u && message.data[18] == 119u && message.data[19] == 21u && message.data[20] == 179u && message.data[21] == 81u && message.data[22] == 239u && message.data[23] == 142u && message.data[24] == 44u && message.data[25] == 202u && message.data[26] == 104u && message.data[27] == 7u && message.data[28] == 165u && message.data[29] == 67u && message.data[30] == 225u && message.data[31] == 127u && message.data[32] == 30u && message.data[33] == 188u && message.data[34] == 90u && message.data[35] == 248u && message.data[36] == 151u && message.data[37] == 53u && message.data[38] == 211u && message.data[39] == 113u && message.data[40] == 15u && message.data[41] == 174u && message.data[42] == 76u && message.data[43] == 234u && message.data[44] == 136u && message.data[45] == 38u && message.data[46] == 197u && message.data[47] == 99u && message.data[48] == 1u && message.data[49] == 159u && message.data[50] == 62u && message.data[51] == 220u && message.data[52] == 122u && message.data[53] == 24u && message.data[54] == 182u && message.data[55] == 85u && message.data[56] == 243u && message.data[57] == 145u && message.data[58] == 47u && message.data[59] == 206u && message.data[60] == 108u && message.data[61] == 10u && message.data[62] == 168u && message.data[63] == 70u;
}

static const uint8_t kPayloadLogPartStream[] = {0x01, 0x49, 0xCB, 0x1A, 0xB9, 0x57, 0xF5, 0x93, 0x31, 0xD0, 0x6E, 0x0C, 0xAA, 0x48, 0xE7, 0x85, 0x23, 0xC1, 0x60, 0xFE, 0x9C, 0x3A, 0xD8, 0x77, 0x15, 0xB3, 0x51, 0xEF, 0x8E, 0x2C, 0xCA, 0x68, 0x07, 0xA5, 0x43, 0xE1, 0x7F, 0x1E, 0xBC, 0x5A, 0xF8, 0x97, 0x35, 0xD3, 0x71, 0x0F, 0xAE, 0x4C, 0xEA, 0x88, 0x26, 0xC5, 0x63, 0x01, 0x9F, 0x3E, 0xDC, 0x7A, 0x18, 0xB6, 0x55, 0xF3, 0x91, 0x2F, 0xCE, 0x6C, 0x0A, 0xA8, 0x46};
static const uint8_t kFrameLogPartStream[] = {0x4A, 0x61, 0x28, 0x01, 0x49, 0xCB, 0x1A, 0xB9, 0x57, 0xF5, 0x93, 0x31, 0xD0, 0x6E, 0x0C, 0xAA, 0x48, 0xE7, 0x85, 0x23, 0xC1, 0x60, 0xFE, 0x9C, 0x3A, 0xD8, 0x77, 0x15, 0xB3, 0x51, 0xEF, 0x8E, 0x2C, 0xCA, 0x68, 0x07, 0xA5, 0x43, 0xE1, 0x7F, 0x1E, 0xBC, 0x5A, 0xF8, 0x97, 0x35, 0xD3, 0x71, 0x0F, 0xAE, 0x4C, 0xEA, 0x88, 0x26, 0xC5, 0x63, 0x01, 0x9F, 0x3E, 0xDC, 0x7A, 0x18, 0xB6, 0x55, 0xF3, 0x91, 0x2F, 0xCE, 0x6C, 0x0A, 0xA8, 0x46, 0x0D, 0xEE, 0x00};

inline size_t build_LogZerosStream(uint8_t* payload) {
  protocol::LogZerosStream message;
  message.first_block = 3843599060u;
  message.count = 33616u;
  message.encode(payload);
  return protocol::LogZerosStream::kSize;
}

inline bool matches_LogZerosStream(const uint8_t* payload, size_t size) {
  protocol::LogZerosStream message;
  if (!message.decode(payload, size)) return false;
  return message.first_block == 3843599060u && message.count == 33616u;
}

static const uint8_t kPayloadLogZerosStream[] = {0xD4, 0xAA, 0x18, 0xE5, 0x50, 0x83};
static const uint8_t kFrameLogZerosStream[] = {0x0B, 0x62, 0x29, 0xD4, 0xAA, 0x18, 0xE5, 0x50, 0x83, 0x34, 0xC2, 0x00};

inline size_t build_LiveSampleStream(uint8_t* payload) {
  protocol::LiveSampleStream message;
  message.index = 562536007u;
  message.time_us = 13816788573682004635ull;
  message.sample.time_offset_us = 4230876019u;
  message.sample.flags = 39525u;
  message.sample.imu[0].accel[0] = -10540;
  message.sample.imu[0].accel[1] = 29963;
  message.sample.imu[0].accel[2] = 4931;
  message.sample.imu[0].temperature = -20102;
  message.sample.imu[0].gyro[0] = 20402;
  message.sample.imu[0].gyro[1] = -4631;
  message.sample.imu[0].gyro[2] = -29663;
  message.sample.imu[1].accel[0] = -14192;
  message.sample.imu[1].accel[1] = 26311;
  message.sample.imu[1].accel[2] = 1279;
  message.sample.imu[1].temperature = -23754;
  message.sample.imu[1].gyro[0] = 16750;
  message.sample.imu[1].gyro[1] = -8283;
  message.sample.imu[1].gyro[2] = 32221;
  message.sample.imu[2].accel[0] = -17844;
  message.sample.imu[2].accel[1] = 22659;
  message.sample.imu[2].accel[2] = -2373;
  message.sample.imu[2].temperature = -27406;
  message.sample.imu[2].gyro[0] = 13097;
  message.sample.imu[2].gyro[1] = -11935;
  message.sample.imu[2].gyro[2] = 28568;
  message.sample.imu[3].accel[0] = -21497;
  message.sample.imu[3].accel[1] = 19007;
  message.sample.imu[3].accel[2] = -6026;
  message.sample.imu[3].temperature = -31058;
  message.sample.imu[3].gyro[0] = 9445;
  message.sample.imu[3].gyro[1] = -15587;
  message.sample.imu[3].gyro[2] = 24916;
  message.sample.angle[0] = 65420u;
  message.sample.angle[1] = 40387u;
  message.sample.angle[2] = 15355u;
  message.sample.angle[3] = 55858u;
  message.sample.angle[4] = 30826u;
  message.sample.angle[5] = 5793u;
  message.encode(payload);
  return protocol::LiveSampleStream::kSize;
}

inline bool matches_LiveSampleStream(const uint8_t* payload, size_t size) {
  protocol::LiveSampleStream message;
  if (!message.decode(payload, size)) return false;
  return message.index == 562536007u && message.time_us == 13816788573682004635ull && message.sample.time_offset_us == 4230876019u && message.sample.flags == 39525u && message.sample.imu[0].accel[0] == -10540 && message.sample.imu[0].accel[1] == 29963 && message.sample.imu[0].accel[2] == 4931 && message.sample.imu[0].temperature == -20102 && message.sample.imu[0].gyro[0] == 20402 && message.sample.imu[0].gyro[1] == -4631 && message.sample.imu[0].gyro[2] == -29663 && message.sample.imu[1].accel[0] == -14192 && message.sample.imu[1].accel[1] == 26311 && message.sample.imu[1].accel[2] == 1279 && message.sample.imu[1].temperature == -23754 && message.sample.imu[1].gyro[0] == 16750 && message.sample.imu[1].gyro[1] == -8283 && message.sample.imu[1].gyro[2] == 32221 && message.sample.imu[2].accel[0] == -17844 && message.sample.imu[2].accel[1] == 22659 && message.sample.imu[2].accel[2] == -2373 && message.sample.imu[2].temperature == -27406 && message.sample.imu[2].gyro[0] == 13097 && message.sample.imu[2].gyro[1] == -11935 && message.sample.imu[2].gyro[2] == 28568 && message.sample.imu[3].accel[0] == -21497 && message.sample.imu[3].accel[1] == 19007 && message.sample.imu[3].accel[2] == -6026 && message.sample.imu[3].temperature == -31058 && message.sample.imu[3].gyro[0] == 9445 && message.sample.imu[3].gyro[1] == -15587 && message.sample.imu[3].gyro[2] == 24916 && message.sample.angle[0] == 65420u && message.sample.angle[1] == 40387u && message.sample.angle[2] == 15355u && message.sample.angle[3] == 55858u && message.sample.angle[4] == 30826u && message.sample.angle[5] == 5793u;
}

static const uint8_t kPayloadLiveSampleStream[] = {0x47, 0x9E, 0x87, 0x21, 0x9B, 0xF2, 0xFD, 0xD6, 0x00, 0x18, 0xBF, 0xBF, 0x73, 0x0B, 0x2E, 0xFC, 0x65, 0x9A, 0xD4, 0xD6, 0x0B, 0x75, 0x43, 0x13, 0x7A, 0xB1, 0xB2, 0x4F, 0xE9, 0xED, 0x21, 0x8C, 0x90, 0xC8, 0xC7, 0x66, 0xFF, 0x04, 0x36, 0xA3, 0x6E, 0x41, 0xA5, 0xDF, 0xDD, 0x7D, 0x4C, 0xBA, 0x83, 0x58, 0xBB, 0xF6, 0xF2, 0x94, 0x29, 0x33, 0x61, 0xD1, 0x98, 0x6F, 0x07, 0xAC, 0x3F, 0x4A, 0x76, 0xE8, 0xAE, 0x86, 0xE5, 0x24, 0x1D, 0xC3, 0x54, 0x61, 0x8C, 0xFF, 0xC3, 0x9D, 0xFB, 0x3B, 0x32, 0xDA, 0x6A, 0x78, 0xA1, 0x16};
static const uint8_t kFrameLiveSampleStream[] = {0x0B, 0x60, 0x2A, 0x47, 0x9E, 0x87, 0x21, 0x9B, 0xF2, 0xFD, 0xD6, 0x50, 0x18, 0xBF, 0xBF, 0x73, 0x0B, 0x2E, 0xFC, 0x65, 0x9A, 0xD4, 0xD6, 0x0B, 0x75, 0x43, 0x13, 0x7A, 0xB1, 0xB2, 0x4F, 0xE9, 0xED, 0x21, 0x8C, 0x90, 0xC8, 0xC7, 0x66, 0xFF, 0x04, 0x36, 0xA3, 0x6E, 0x41, 0xA5, 0xDF, 0xDD, 0x7D, 0x4C, 0xBA, 0x83, 0x58, 0xBB, 0xF6, 0xF2, 0x94, 0x29, 0x33, 0x61, 0xD1, 0x98, 0x6F, 0x07, 0xAC, 0x3F, 0x4A, 0x76, 0xE8, 0xAE, 0x86, 0xE5, 0x24, 0x1D, 0xC3, 0x54, 0x61, 0x8C, 0xFF, 0xC3, 0x9D, 0xFB, 0x3B, 0x32, 0xDA, 0x6A, 0x78, 0xA1, 0x16, 0xBD, 0x31, 0x00};

inline size_t build_ErrorReply(uint8_t* payload) {
  protocol::ErrorReply message;
  message.request = 180u;
  message.code = protocol::ErrorCode::kNoSuchLog;
  message.detail = -246938654;
  message.encode(payload);
  return protocol::ErrorReply::kSize;
}

inline bool matches_ErrorReply(const uint8_t* payload, size_t size) {
  protocol::ErrorReply message;
  if (!message.decode(payload, size)) return false;
  return message.request == 180u && message.code == protocol::ErrorCode::kNoSuchLog && message.detail == -246938654;
}

static const uint8_t kPayloadErrorReply[] = {0xB4, 0x34, 0xE2, 0x03, 0x48, 0xF1};
static const uint8_t kFrameErrorReply[] = {0x0B, 0xFF, 0x2B, 0xB4, 0x34, 0xE2, 0x03, 0x48, 0xF1, 0xC4, 0xB3, 0x00};

inline size_t build_SettingsWriteRequest(uint8_t* payload) {
  protocol::SettingsWriteRequest message;
  message.frame_us = 36735u;
  message.servo[0].zero_us = 52206u;
  message.servo[0].ns_per_deg = 27173u;
  message.servo[0].reversed = 8u;
  message.servo[0].min_cdeg = -22892;
  message.servo[0].max_cdeg = 17612;
  message.servo[1].zero_us = 33083u;
  message.servo[1].ns_per_deg = 8050u;
  message.servo[1].reversed = 189u;
  message.servo[1].min_cdeg = 23521;
  message.servo[1].max_cdeg = -1511;
  message.servo[2].zero_us = 13960u;
  message.servo[2].ns_per_deg = 54463u;
  message.servo[2].reversed = 114u;
  message.servo[2].min_cdeg = 4398;
  message.servo[2].max_cdeg = -20634;
  message.moving_at_once = 77u;
  message.encode(payload);
  return protocol::SettingsWriteRequest::kSize;
}

inline bool matches_SettingsWriteRequest(const uint8_t* payload, size_t size) {
  protocol::SettingsWriteRequest message;
  if (!message.decode(payload, size)) return false;
  return message.frame_us == 36735u && message.servo[0].zero_us == 52206u && message.servo[0].ns_per_deg == 27173u && message.servo[0].reversed == 8u && message.servo[0].min_cdeg == -22892 && message.servo[0].max_cdeg == 17612 && message.servo[1].zero_us == 33083u && message.servo[1].ns_per_deg == 8050u && message.servo[1].reversed == 189u && message.servo[1].min_cdeg == 23521 && message.servo[1].max_cdeg == -1511 && message.servo[2].zero_us == 13960u && message.servo[2].ns_per_deg == 54463u && message.servo[2].reversed == 114u && message.servo[2].min_cdeg == 4398 && message.servo[2].max_cdeg == -20634 && message.moving_at_once == 77u;
}

static const uint8_t kPayloadSettingsWriteRequest[] = {0x7F, 0x8F, 0xEE, 0xCB, 0x25, 0x6A, 0x08, 0x94, 0xA6, 0xCC, 0x44, 0x3B, 0x81, 0x72, 0x1F, 0xBD, 0xE1, 0x5B, 0x19, 0xFA, 0x88, 0x36, 0xBF, 0xD4, 0x72, 0x2E, 0x11, 0x66, 0xAF, 0x4D};
static const uint8_t kFrameSettingsWriteRequest[] = {0x23, 0x15, 0x2C, 0x7F, 0x8F, 0xEE, 0xCB, 0x25, 0x6A, 0x08, 0x94, 0xA6, 0xCC, 0x44, 0x3B, 0x81, 0x72, 0x1F, 0xBD, 0xE1, 0x5B, 0x19, 0xFA, 0x88, 0x36, 0xBF, 0xD4, 0x72, 0x2E, 0x11, 0x66, 0xAF, 0x4D, 0xD1, 0x75, 0x00};

inline size_t build_SettingsWriteReply(uint8_t* payload) {
  protocol::SettingsWriteReply message;
  message.stored = 235u;
  message.written = 138u;
  message.encode(payload);
  return protocol::SettingsWriteReply::kSize;
}

inline bool matches_SettingsWriteReply(const uint8_t* payload, size_t size) {
  protocol::SettingsWriteReply message;
  if (!message.decode(payload, size)) return false;
  return message.stored == 235u && message.written == 138u;
}

static const uint8_t kPayloadSettingsWriteReply[] = {0xEB, 0x8A};
static const uint8_t kFrameSettingsWriteReply[] = {0x07, 0x95, 0x2D, 0xEB, 0x8A, 0x07, 0xC6, 0x00};

inline size_t build_SettingsReadRequest(uint8_t* payload) {
  (void)payload;
  return protocol::SettingsReadRequest::kSize;
}

inline bool matches_SettingsReadRequest(const uint8_t* payload, size_t size) {
  (void)payload;
  if (size != 0) return false;
  return true;
}

static const uint8_t kPayloadSettingsReadRequest[] = {0};
static const uint8_t kFrameSettingsReadRequest[] = {0x05, 0x16, 0x2E, 0x76, 0x71, 0x00};

inline size_t build_SettingsReadReply(uint8_t* payload) {
  protocol::SettingsReadReply message;
  message.origin = protocol::Origin::kUploaded;
  message.generation = 3329977670u;
  message.frame_us = 25778u;
  message.servo[0].zero_us = 41249u;
  message.servo[0].ns_per_deg = 16217u;
  message.servo[0].reversed = 221u;
  message.servo[0].min_cdeg = 31688;
  message.servo[0].max_cdeg = 6655;
  message.servo[1].zero_us = 22126u;
  message.servo[1].ns_per_deg = 62630u;
  message.servo[1].reversed = 146u;
  message.servo[1].min_cdeg = 12565;
  message.servo[1].max_cdeg = -12468;
  message.servo[2].zero_us = 3003u;
  message.servo[2].ns_per_deg = 43507u;
  message.servo[2].reversed = 72u;
  message.servo[2].min_cdeg = -6559;
  message.servo[2].max_cdeg = -31591;
  message.moving_at_once = 34u;
  message.encode(payload);
  return protocol::SettingsReadReply::kSize;
}

inline bool matches_SettingsReadReply(const uint8_t* payload, size_t size) {
  protocol::SettingsReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.origin == protocol::Origin::kUploaded && message.generation == 3329977670u && message.frame_us == 25778u && message.servo[0].zero_us == 41249u && message.servo[0].ns_per_deg == 16217u && message.servo[0].reversed == 221u && message.servo[0].min_cdeg == 31688 && message.servo[0].max_cdeg == 6655 && message.servo[1].zero_us == 22126u && message.servo[1].ns_per_deg == 62630u && message.servo[1].reversed == 146u && message.servo[1].min_cdeg == 12565 && message.servo[1].max_cdeg == -12468 && message.servo[2].zero_us == 3003u && message.servo[2].ns_per_deg == 43507u && message.servo[2].reversed == 72u && message.servo[2].min_cdeg == -6559 && message.servo[2].max_cdeg == -31591 && message.moving_at_once == 34u;
}

static const uint8_t kPayloadSettingsReadReply[] = {0x01, 0x46, 0x6D, 0x7B, 0xC6, 0xB2, 0x64, 0x21, 0xA1, 0x59, 0x3F, 0xDD, 0xC8, 0x7B, 0xFF, 0x19, 0x6E, 0x56, 0xA6, 0xF4, 0x92, 0x15, 0x31, 0x4C, 0xCF, 0xBB, 0x0B, 0xF3, 0xA9, 0x48, 0x61, 0xE6, 0x99, 0x84, 0x22};
static const uint8_t kFrameSettingsReadReply[] = {0x28, 0x96, 0x2F, 0x01, 0x46, 0x6D, 0x7B, 0xC6, 0xB2, 0x64, 0x21, 0xA1, 0x59, 0x3F, 0xDD, 0xC8, 0x7B, 0xFF, 0x19, 0x6E, 0x56, 0xA6, 0xF4, 0x92, 0x15, 0x31, 0x4C, 0xCF, 0xBB, 0x0B, 0xF3, 0xA9, 0x48, 0x61, 0xE6, 0x99, 0x84, 0x22, 0x1A, 0xD4, 0x00};

inline size_t build_JointReportRequest(uint8_t* payload) {
  protocol::JointReportRequest message;
  message.angle_cdeg[0] = -16120;
  message.angle_cdeg[1] = 24383;
  message.angle_cdeg[2] = -649;
  message.encode(payload);
  return protocol::JointReportRequest::kSize;
}

inline bool matches_JointReportRequest(const uint8_t* payload, size_t size) {
  protocol::JointReportRequest message;
  if (!message.decode(payload, size)) return false;
  return message.angle_cdeg[0] == -16120 && message.angle_cdeg[1] == 24383 && message.angle_cdeg[2] == -649;
}

static const uint8_t kPayloadJointReportRequest[] = {0x08, 0xC1, 0x3F, 0x5F, 0x77, 0xFD};
static const uint8_t kFrameJointReportRequest[] = {0x0B, 0x22, 0x30, 0x08, 0xC1, 0x3F, 0x5F, 0x77, 0xFD, 0x52, 0x2D, 0x00};

inline size_t build_JointReportReply(uint8_t* payload) {
  protocol::JointReportReply message;
  message.at_start_pose = 155u;
  message.encode(payload);
  return protocol::JointReportReply::kSize;
}

inline bool matches_JointReportReply(const uint8_t* payload, size_t size) {
  protocol::JointReportReply message;
  if (!message.decode(payload, size)) return false;
  return message.at_start_pose == 155u;
}

static const uint8_t kPayloadJointReportReply[] = {0x9B};
static const uint8_t kFrameJointReportReply[] = {0x06, 0xA2, 0x31, 0x9B, 0x16, 0x1B, 0x00};

inline size_t build_JogRequest(uint8_t* payload) {
  protocol::JogRequest message;
  message.joint = 57u;
  message.from_cdeg = -10211;
  message.to_cdeg = 30293;
  message.confirm = 344767888u;
  message.encode(payload);
  return protocol::JogRequest::kSize;
}

inline bool matches_JogRequest(const uint8_t* payload, size_t size) {
  protocol::JogRequest message;
  if (!message.decode(payload, size)) return false;
  return message.joint == 57u && message.from_cdeg == -10211 && message.to_cdeg == 30293 && message.confirm == 344767888u;
}

static const uint8_t kPayloadJogRequest[] = {0x39, 0x1D, 0xD8, 0x55, 0x76, 0x90, 0xBD, 0x8C, 0x14};
static const uint8_t kFrameJogRequest[] = {0x0E, 0x23, 0x32, 0x39, 0x1D, 0xD8, 0x55, 0x76, 0x90, 0xBD, 0x8C, 0x14, 0xB4, 0x6F, 0x00};

inline size_t build_JogReply(uint8_t* payload) {
  protocol::JogReply message;
  message.angle_cdeg = -19772;
  message.arrived = 80u;
  message.encode(payload);
  return protocol::JogReply::kSize;
}

inline bool matches_JogReply(const uint8_t* payload, size_t size) {
  protocol::JogReply message;
  if (!message.decode(payload, size)) return false;
  return message.angle_cdeg == -19772 && message.arrived == 80u;
}

static const uint8_t kPayloadJogReply[] = {0xC4, 0xB2, 0x50};
static const uint8_t kFrameJogReply[] = {0x08, 0xA3, 0x33, 0xC4, 0xB2, 0x50, 0x22, 0xBA, 0x00};

static const Vector kVectors[] = {
    {"HelloRequest", protocol::HelloRequest::kType, 0, build_HelloRequest, matches_HelloRequest, kPayloadHelloRequest, 0, kFrameHelloRequest, 6},
    {"HelloReply", protocol::HelloReply::kType, 1, build_HelloReply, matches_HelloReply, kPayloadHelloReply, 24, kFrameHelloReply, 30},
    {"SequencerStatusRequest", protocol::SequencerStatusRequest::kType, 2, build_SequencerStatusRequest, matches_SequencerStatusRequest, kPayloadSequencerStatusRequest, 0, kFrameSequencerStatusRequest, 6},
    {"SequencerStatusReply", protocol::SequencerStatusReply::kType, 3, build_SequencerStatusReply, matches_SequencerStatusReply, kPayloadSequencerStatusReply, 34, kFrameSequencerStatusReply, 40},
    {"RunReportRequest", protocol::RunReportRequest::kType, 4, build_RunReportRequest, matches_RunReportRequest, kPayloadRunReportRequest, 0, kFrameRunReportRequest, 6},
    {"RunReportReply", protocol::RunReportReply::kType, 5, build_RunReportReply, matches_RunReportReply, kPayloadRunReportReply, 82, kFrameRunReportReply, 88},
    {"LoggerStatusRequest", protocol::LoggerStatusRequest::kType, 6, build_LoggerStatusRequest, matches_LoggerStatusRequest, kPayloadLoggerStatusRequest, 0, kFrameLoggerStatusRequest, 6},
    {"LoggerStatusReply", protocol::LoggerStatusReply::kType, 7, build_LoggerStatusReply, matches_LoggerStatusReply, kPayloadLoggerStatusReply, 57, kFrameLoggerStatusReply, 63},
    {"ManeuverBeginRequest", protocol::ManeuverBeginRequest::kType, 8, build_ManeuverBeginRequest, matches_ManeuverBeginRequest, kPayloadManeuverBeginRequest, 3, kFrameManeuverBeginRequest, 9},
    {"ManeuverBeginReply", protocol::ManeuverBeginReply::kType, 9, build_ManeuverBeginReply, matches_ManeuverBeginReply, kPayloadManeuverBeginReply, 1, kFrameManeuverBeginReply, 7},
    {"ManeuverStrokeRequest", protocol::ManeuverStrokeRequest::kType, 10, build_ManeuverStrokeRequest, matches_ManeuverStrokeRequest, kPayloadManeuverStrokeRequest, 8, kFrameManeuverStrokeRequest, 14},
    {"ManeuverStrokeReply", protocol::ManeuverStrokeReply::kType, 11, build_ManeuverStrokeReply, matches_ManeuverStrokeReply, kPayloadManeuverStrokeReply, 1, kFrameManeuverStrokeReply, 7},
    {"ManeuverCommitRequest", protocol::ManeuverCommitRequest::kType, 12, build_ManeuverCommitRequest, matches_ManeuverCommitRequest, kPayloadManeuverCommitRequest, 2, kFrameManeuverCommitRequest, 8},
    {"ManeuverCommitReply", protocol::ManeuverCommitReply::kType, 13, build_ManeuverCommitReply, matches_ManeuverCommitReply, kPayloadManeuverCommitReply, 2, kFrameManeuverCommitReply, 8},
    {"ManeuverInfoRequest", protocol::ManeuverInfoRequest::kType, 14, build_ManeuverInfoRequest, matches_ManeuverInfoRequest, kPayloadManeuverInfoRequest, 0, kFrameManeuverInfoRequest, 6},
    {"ManeuverInfoReply", protocol::ManeuverInfoReply::kType, 15, build_ManeuverInfoReply, matches_ManeuverInfoReply, kPayloadManeuverInfoReply, 14, kFrameManeuverInfoReply, 20},
    {"ManeuverReadRequest", protocol::ManeuverReadRequest::kType, 16, build_ManeuverReadRequest, matches_ManeuverReadRequest, kPayloadManeuverReadRequest, 1, kFrameManeuverReadRequest, 7},
    {"ManeuverReadReply", protocol::ManeuverReadReply::kType, 17, build_ManeuverReadReply, matches_ManeuverReadReply, kPayloadManeuverReadReply, 8, kFrameManeuverReadReply, 14},
    {"ArmRequest", protocol::ArmRequest::kType, 18, build_ArmRequest, matches_ArmRequest, kPayloadArmRequest, 2, kFrameArmRequest, 8},
    {"ArmReply", protocol::ArmReply::kType, 19, build_ArmReply, matches_ArmReply, kPayloadArmReply, 1, kFrameArmReply, 7},
    {"DisarmRequest", protocol::DisarmRequest::kType, 20, build_DisarmRequest, matches_DisarmRequest, kPayloadDisarmRequest, 0, kFrameDisarmRequest, 6},
    {"DisarmReply", protocol::DisarmReply::kType, 21, build_DisarmReply, matches_DisarmReply, kPayloadDisarmReply, 1, kFrameDisarmReply, 7},
    {"RecordStartRequest", protocol::RecordStartRequest::kType, 22, build_RecordStartRequest, matches_RecordStartRequest, kPayloadRecordStartRequest, 15, kFrameRecordStartRequest, 21},
    {"RecordStartReply", protocol::RecordStartReply::kType, 23, build_RecordStartReply, matches_RecordStartReply, kPayloadRecordStartReply, 5, kFrameRecordStartReply, 11},
    {"RecordStopRequest", protocol::RecordStopRequest::kType, 24, build_RecordStopRequest, matches_RecordStopRequest, kPayloadRecordStopRequest, 0, kFrameRecordStopRequest, 6},
    {"RecordStopReply", protocol::RecordStopReply::kType, 25, build_RecordStopReply, matches_RecordStopReply, kPayloadRecordStopReply, 13, kFrameRecordStopReply, 19},
    {"LiveRequest", protocol::LiveRequest::kType, 26, build_LiveRequest, matches_LiveRequest, kPayloadLiveRequest, 1, kFrameLiveRequest, 7},
    {"LiveReply", protocol::LiveReply::kType, 27, build_LiveReply, matches_LiveReply, kPayloadLiveReply, 40, kFrameLiveReply, 46},
    {"LoggerSettingsWriteRequest", protocol::LoggerSettingsWriteRequest::kType, 28, build_LoggerSettingsWriteRequest, matches_LoggerSettingsWriteRequest, kPayloadLoggerSettingsWriteRequest, 12, kFrameLoggerSettingsWriteRequest, 18},
    {"LoggerSettingsWriteReply", protocol::LoggerSettingsWriteReply::kType, 29, build_LoggerSettingsWriteReply, matches_LoggerSettingsWriteReply, kPayloadLoggerSettingsWriteReply, 1, kFrameLoggerSettingsWriteReply, 7},
    {"LoggerSettingsReadRequest", protocol::LoggerSettingsReadRequest::kType, 30, build_LoggerSettingsReadRequest, matches_LoggerSettingsReadRequest, kPayloadLoggerSettingsReadRequest, 0, kFrameLoggerSettingsReadRequest, 6},
    {"LoggerSettingsReadReply", protocol::LoggerSettingsReadReply::kType, 31, build_LoggerSettingsReadReply, matches_LoggerSettingsReadReply, kPayloadLoggerSettingsReadReply, 15, kFrameLoggerSettingsReadReply, 21},
    {"ClockSetRequest", protocol::ClockSetRequest::kType, 32, build_ClockSetRequest, matches_ClockSetRequest, kPayloadClockSetRequest, 8, kFrameClockSetRequest, 14},
    {"ClockSetReply", protocol::ClockSetReply::kType, 33, build_ClockSetReply, matches_ClockSetReply, kPayloadClockSetReply, 8, kFrameClockSetReply, 14},
    {"LogListRequest", protocol::LogListRequest::kType, 34, build_LogListRequest, matches_LogListRequest, kPayloadLogListRequest, 2, kFrameLogListRequest, 8},
    {"LogListReply", protocol::LogListReply::kType, 35, build_LogListReply, matches_LogListReply, kPayloadLogListReply, 20, kFrameLogListReply, 26},
    {"LogReadRequest", protocol::LogReadRequest::kType, 36, build_LogReadRequest, matches_LogReadRequest, kPayloadLogReadRequest, 12, kFrameLogReadRequest, 18},
    {"LogReadReply", protocol::LogReadReply::kType, 37, build_LogReadReply, matches_LogReadReply, kPayloadLogReadReply, 2, kFrameLogReadReply, 8},
    {"LogEraseRequest", protocol::LogEraseRequest::kType, 38, build_LogEraseRequest, matches_LogEraseRequest, kPayloadLogEraseRequest, 6, kFrameLogEraseRequest, 12},
    {"LogEraseReply", protocol::LogEraseReply::kType, 39, build_LogEraseReply, matches_LogEraseReply, kPayloadLogEraseReply, 1, kFrameLogEraseReply, 7},
    {"LogPartStream", protocol::LogPartStream::kType, 40, build_LogPartStream, matches_LogPartStream, kPayloadLogPartStream, 69, kFrameLogPartStream, 75},
    {"LogZerosStream", protocol::LogZerosStream::kType, 41, build_LogZerosStream, matches_LogZerosStream, kPayloadLogZerosStream, 6, kFrameLogZerosStream, 12},
    {"LiveSampleStream", protocol::LiveSampleStream::kType, 42, build_LiveSampleStream, matches_LiveSampleStream, kPayloadLiveSampleStream, 86, kFrameLiveSampleStream, 92},
    {"ErrorReply", protocol::ErrorReply::kType, 43, build_ErrorReply, matches_ErrorReply, kPayloadErrorReply, 6, kFrameErrorReply, 12},
    {"SettingsWriteRequest", protocol::SettingsWriteRequest::kType, 44, build_SettingsWriteRequest, matches_SettingsWriteRequest, kPayloadSettingsWriteRequest, 30, kFrameSettingsWriteRequest, 36},
    {"SettingsWriteReply", protocol::SettingsWriteReply::kType, 45, build_SettingsWriteReply, matches_SettingsWriteReply, kPayloadSettingsWriteReply, 2, kFrameSettingsWriteReply, 8},
    {"SettingsReadRequest", protocol::SettingsReadRequest::kType, 46, build_SettingsReadRequest, matches_SettingsReadRequest, kPayloadSettingsReadRequest, 0, kFrameSettingsReadRequest, 6},
    {"SettingsReadReply", protocol::SettingsReadReply::kType, 47, build_SettingsReadReply, matches_SettingsReadReply, kPayloadSettingsReadReply, 35, kFrameSettingsReadReply, 41},
    {"JointReportRequest", protocol::JointReportRequest::kType, 48, build_JointReportRequest, matches_JointReportRequest, kPayloadJointReportRequest, 6, kFrameJointReportRequest, 12},
    {"JointReportReply", protocol::JointReportReply::kType, 49, build_JointReportReply, matches_JointReportReply, kPayloadJointReportReply, 1, kFrameJointReportReply, 7},
    {"JogRequest", protocol::JogRequest::kType, 50, build_JogRequest, matches_JogRequest, kPayloadJogRequest, 9, kFrameJogRequest, 15},
    {"JogReply", protocol::JogReply::kType, 51, build_JogReply, matches_JogReply, kPayloadJogReply, 3, kFrameJogReply, 9},
};

}  // namespace golden
}  // namespace tfsat

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
  message.encode(payload);
  return protocol::SequencerStatusReply::kSize;
}

inline bool matches_SequencerStatusReply(const uint8_t* payload, size_t size) {
  protocol::SequencerStatusReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kFault && message.fault == protocol::ErrorCode::kResetWhileRunning && message.last_refusal == protocol::ErrorCode::kJogNotConfirmed && message.switches_open == 116u && message.arm_token == 4805u && message.reset_cause == protocol::ResetCause::kBrownOut && message.resets_while_armed == 79u && message.strokes_started == 237u && message.knocks == 35747u && message.joint_angle_cdeg[0] == 10715 && message.joint_angle_cdeg[1] == -14318 && message.joint_angle_cdeg[2] == 26185 && message.uptime_ms == 75591690u && message.image_crc == 2730027459u && message.ram_never_used_bytes == 16624u && message.frames_rejected == 57127u && message.stores_damaged == 125u && message.false_releases == 7062u && message.servos_driven == 185u;
}

static const uint8_t kPayloadSequencerStatusReply[] = {0x04, 0x17, 0x18, 0x74, 0xC5, 0x12, 0x02, 0x4F, 0xED, 0xA3, 0x8B, 0xDB, 0x29, 0x12, 0xC8, 0x49, 0x66, 0x0A, 0x70, 0x81, 0x04, 0xC3, 0xE9, 0xB8, 0xA2, 0xF0, 0x40, 0x27, 0xDF, 0x7D, 0x96, 0x1B, 0xB9};
static const uint8_t kFrameSequencerStatusReply[] = {0x26, 0x82, 0x03, 0x04, 0x17, 0x18, 0x74, 0xC5, 0x12, 0x02, 0x4F, 0xED, 0xA3, 0x8B, 0xDB, 0x29, 0x12, 0xC8, 0x49, 0x66, 0x0A, 0x70, 0x81, 0x04, 0xC3, 0xE9, 0xB8, 0xA2, 0xF0, 0x40, 0x27, 0xDF, 0x7D, 0x96, 0x1B, 0xB9, 0x5C, 0x75, 0x00};

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
  message.released = 88u;
  message.bounces = 63037u;
  message.release_ms = 2490677135u;
  message.release_us = 12972u;
  message.stroke_count = 208u;
  message.start_us[0] = 1864049852u;
  message.start_us[1] = 223518325u;
  message.start_us[2] = 2877954095u;
  message.start_us[3] = 1237422568u;
  message.start_us[4] = 3891858338u;
  message.start_us[5] = 2251326811u;
  message.start_us[6] = 610795285u;
  message.start_us[7] = 3265231054u;
  message.start_us[8] = 1624699528u;
  message.start_us[9] = 4279135297u;
  message.start_us[10] = 2638603771u;
  message.start_us[11] = 998072244u;
  message.start_us[12] = 3652508014u;
  message.start_us[13] = 2011976487u;
  message.start_us[14] = 371444961u;
  message.start_us[15] = 3025880730u;
  message.earlier_us = 1385349204u;
  message.later_us = 4039784973u;
  message.encode(payload);
  return protocol::RunReportReply::kSize;
}

inline bool matches_RunReportReply(const uint8_t* payload, size_t size) {
  protocol::RunReportReply message;
  if (!message.decode(payload, size)) return false;
  return message.released == 88u && message.bounces == 63037u && message.release_ms == 2490677135u && message.release_us == 12972u && message.stroke_count == 208u && message.start_us[0] == 1864049852u && message.start_us[1] == 223518325u && message.start_us[2] == 2877954095u && message.start_us[3] == 1237422568u && message.start_us[4] == 3891858338u && message.start_us[5] == 2251326811u && message.start_us[6] == 610795285u && message.start_us[7] == 3265231054u && message.start_us[8] == 1624699528u && message.start_us[9] == 4279135297u && message.start_us[10] == 2638603771u && message.start_us[11] == 998072244u && message.start_us[12] == 3652508014u && message.start_us[13] == 2011976487u && message.start_us[14] == 371444961u && message.start_us[15] == 3025880730u && message.earlier_us == 1385349204u && message.later_us == 4039784973u;
}

static const uint8_t kPayloadRunReportReply[] = {0x58, 0x3D, 0xF6, 0x8F, 0xB7, 0x74, 0x94, 0xAC, 0x32, 0xD0, 0xBC, 0x24, 0x1B, 0x6F, 0x75, 0x9E, 0x52, 0x0D, 0x2F, 0x18, 0x8A, 0xAB, 0xE8, 0x91, 0xC1, 0x49, 0xA2, 0x0B, 0xF9, 0xE7, 0x5B, 0x85, 0x30, 0x86, 0x15, 0xFF, 0x67, 0x24, 0xCE, 0x78, 0x9F, 0xC2, 0x88, 0xF2, 0xD6, 0x60, 0x41, 0x6C, 0x0E, 0xFF, 0xFB, 0xE5, 0x45, 0x9D, 0xB4, 0x5F, 0x7D, 0x3B, 0x6E, 0xD9, 0xB4, 0xD9, 0x27, 0x53, 0xEC, 0x77, 0xE1, 0xCC, 0x23, 0x16, 0x9A, 0x46, 0x5B, 0xB4, 0x54, 0xC0, 0x92, 0x52, 0x0D, 0x3A, 0xCA, 0xF0};
static const uint8_t kFrameRunReportReply[] = {0x57, 0x84, 0x05, 0x58, 0x3D, 0xF6, 0x8F, 0xB7, 0x74, 0x94, 0xAC, 0x32, 0xD0, 0xBC, 0x24, 0x1B, 0x6F, 0x75, 0x9E, 0x52, 0x0D, 0x2F, 0x18, 0x8A, 0xAB, 0xE8, 0x91, 0xC1, 0x49, 0xA2, 0x0B, 0xF9, 0xE7, 0x5B, 0x85, 0x30, 0x86, 0x15, 0xFF, 0x67, 0x24, 0xCE, 0x78, 0x9F, 0xC2, 0x88, 0xF2, 0xD6, 0x60, 0x41, 0x6C, 0x0E, 0xFF, 0xFB, 0xE5, 0x45, 0x9D, 0xB4, 0x5F, 0x7D, 0x3B, 0x6E, 0xD9, 0xB4, 0xD9, 0x27, 0x53, 0xEC, 0x77, 0xE1, 0xCC, 0x23, 0x16, 0x9A, 0x46, 0x5B, 0xB4, 0x54, 0xC0, 0x92, 0x52, 0x0D, 0x3A, 0xCA, 0xF0, 0xE7, 0x9C, 0x00};

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
  message.state = protocol::LoggerState::kFailed;
  message.error = protocol::ErrorCode::kStaleToken;
  message.imu_present = 203u;
  message.switches_open = 105u;
  message.session = 132094637u;
  message.samples = 2786530406u;
  message.samples_dropped = 1145998880u;
  message.blocks_written = 3800434649u;
  message.ring_blocks = 32957u;
  message.ring_peak_blocks = 7924u;
  message.rate_hz = 48428u;
  message.who_am_i[0] = 91u;
  message.who_am_i[1] = 249u;
  message.who_am_i[2] = 151u;
  message.who_am_i[3] = 54u;
  message.uptime_ms = 3561084325u;
  message.card = protocol::CardState::kUnreadable;
  message.card_free_mib = 280021272u;
  message.phase = protocol::DropPhase::kFalling;
  message.ram_holds_drop = 77u;
  message.late_ticks = 3948361285u;
  message.settings_origin = protocol::Origin::kUploaded;
  message.unix_us = 2866024084405320957ull;
  message.encode(payload);
  return protocol::LoggerStatusReply::kSize;
}

inline bool matches_LoggerStatusReply(const uint8_t* payload, size_t size) {
  protocol::LoggerStatusReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kFailed && message.error == protocol::ErrorCode::kStaleToken && message.imu_present == 203u && message.switches_open == 105u && message.session == 132094637u && message.samples == 2786530406u && message.samples_dropped == 1145998880u && message.blocks_written == 3800434649u && message.ring_blocks == 32957u && message.ring_peak_blocks == 7924u && message.rate_hz == 48428u && message.who_am_i[0] == 91u && message.who_am_i[1] == 249u && message.who_am_i[2] == 151u && message.who_am_i[3] == 54u && message.uptime_ms == 3561084325u && message.card == protocol::CardState::kUnreadable && message.card_free_mib == 280021272u && message.phase == protocol::DropPhase::kFalling && message.ram_holds_drop == 77u && message.late_ticks == 3948361285u && message.settings_origin == protocol::Origin::kUploaded && message.unix_us == 2866024084405320957ull;
}

static const uint8_t kPayloadLoggerStatusReply[] = {0x04, 0x11, 0xCB, 0x69, 0xAD, 0x9A, 0xDF, 0x07, 0x66, 0x14, 0x17, 0xA6, 0x20, 0x8E, 0x4E, 0x44, 0xD9, 0x07, 0x86, 0xE2, 0xBD, 0x80, 0xF4, 0x1E, 0x2C, 0xBD, 0x5B, 0xF9, 0x97, 0x36, 0xA5, 0xD5, 0x41, 0xD4, 0x03, 0x18, 0xC9, 0xB0, 0x10, 0x01, 0x4D, 0x45, 0x36, 0x57, 0xEB, 0x01, 0xFD, 0x7C, 0xB1, 0x4C, 0xB8, 0x29, 0xC6, 0x27};
static const uint8_t kFrameLoggerStatusReply[] = {0x3B, 0x83, 0x07, 0x04, 0x11, 0xCB, 0x69, 0xAD, 0x9A, 0xDF, 0x07, 0x66, 0x14, 0x17, 0xA6, 0x20, 0x8E, 0x4E, 0x44, 0xD9, 0x07, 0x86, 0xE2, 0xBD, 0x80, 0xF4, 0x1E, 0x2C, 0xBD, 0x5B, 0xF9, 0x97, 0x36, 0xA5, 0xD5, 0x41, 0xD4, 0x03, 0x18, 0xC9, 0xB0, 0x10, 0x01, 0x4D, 0x45, 0x36, 0x57, 0xEB, 0x01, 0xFD, 0x7C, 0xB1, 0x4C, 0xB8, 0x29, 0xC6, 0x27, 0xF0, 0x49, 0x00};

inline size_t build_ManeuverBeginRequest(uint8_t* payload) {
  protocol::ManeuverBeginRequest message;
  message.stroke_count = 197u;
  message.speed_cdeg_s = 25653u;
  message.encode(payload);
  return protocol::ManeuverBeginRequest::kSize;
}

inline bool matches_ManeuverBeginRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverBeginRequest message;
  if (!message.decode(payload, size)) return false;
  return message.stroke_count == 197u && message.speed_cdeg_s == 25653u;
}

static const uint8_t kPayloadManeuverBeginRequest[] = {0xC5, 0x35, 0x64};
static const uint8_t kFrameManeuverBeginRequest[] = {0x08, 0x10, 0x08, 0xC5, 0x35, 0x64, 0xD0, 0x8B, 0x00};

inline size_t build_ManeuverBeginReply(uint8_t* payload) {
  protocol::ManeuverBeginReply message;
  message.stroke_count = 2u;
  message.encode(payload);
  return protocol::ManeuverBeginReply::kSize;
}

inline bool matches_ManeuverBeginReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverBeginReply message;
  if (!message.decode(payload, size)) return false;
  return message.stroke_count == 2u;
}

static const uint8_t kPayloadManeuverBeginReply[] = {0x02};
static const uint8_t kFrameManeuverBeginReply[] = {0x06, 0x90, 0x09, 0x02, 0x7F, 0x2E, 0x00};

inline size_t build_ManeuverStrokeRequest(uint8_t* payload) {
  protocol::ManeuverStrokeRequest message;
  message.index = 160u;
  message.joint = 62u;
  message.angle_cdeg = -8941;
  message.start_us = 2068479434u;
  message.encode(payload);
  return protocol::ManeuverStrokeRequest::kSize;
}

inline bool matches_ManeuverStrokeRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverStrokeRequest message;
  if (!message.decode(payload, size)) return false;
  return message.index == 160u && message.joint == 62u && message.angle_cdeg == -8941 && message.start_us == 2068479434u;
}

static const uint8_t kPayloadManeuverStrokeRequest[] = {0xA0, 0x3E, 0x13, 0xDD, 0xCA, 0x7D, 0x4A, 0x7B};
static const uint8_t kFrameManeuverStrokeRequest[] = {0x0D, 0x11, 0x0A, 0xA0, 0x3E, 0x13, 0xDD, 0xCA, 0x7D, 0x4A, 0x7B, 0xCF, 0xB6, 0x00};

inline size_t build_ManeuverStrokeReply(uint8_t* payload) {
  protocol::ManeuverStrokeReply message;
  message.index = 25u;
  message.encode(payload);
  return protocol::ManeuverStrokeReply::kSize;
}

inline bool matches_ManeuverStrokeReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverStrokeReply message;
  if (!message.decode(payload, size)) return false;
  return message.index == 25u;
}

static const uint8_t kPayloadManeuverStrokeReply[] = {0x19};
static const uint8_t kFrameManeuverStrokeReply[] = {0x06, 0x91, 0x0B, 0x19, 0x77, 0xDC, 0x00};

inline size_t build_ManeuverCommitRequest(uint8_t* payload) {
  protocol::ManeuverCommitRequest message;
  message.crc = 47033u;
  message.encode(payload);
  return protocol::ManeuverCommitRequest::kSize;
}

inline bool matches_ManeuverCommitRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverCommitRequest message;
  if (!message.decode(payload, size)) return false;
  return message.crc == 47033u;
}

static const uint8_t kPayloadManeuverCommitRequest[] = {0xB9, 0xB7};
static const uint8_t kFrameManeuverCommitRequest[] = {0x07, 0x12, 0x0C, 0xB9, 0xB7, 0xC7, 0x74, 0x00};

inline size_t build_ManeuverCommitReply(uint8_t* payload) {
  protocol::ManeuverCommitReply message;
  message.stored = 85u;
  message.written = 244u;
  message.encode(payload);
  return protocol::ManeuverCommitReply::kSize;
}

inline bool matches_ManeuverCommitReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverCommitReply message;
  if (!message.decode(payload, size)) return false;
  return message.stored == 85u && message.written == 244u;
}

static const uint8_t kPayloadManeuverCommitReply[] = {0x55, 0xF4};
static const uint8_t kFrameManeuverCommitReply[] = {0x07, 0x92, 0x0D, 0x55, 0xF4, 0xB7, 0xB3, 0x00};

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
  message.origin = protocol::Origin::kFactory;
  message.stroke_count = 48u;
  message.speed_cdeg_s = 52942u;
  message.crc = 27910u;
  message.end_us = 188597584u;
  message.generation = 2843033353u;
  message.encode(payload);
  return protocol::ManeuverInfoReply::kSize;
}

inline bool matches_ManeuverInfoReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverInfoReply message;
  if (!message.decode(payload, size)) return false;
  return message.origin == protocol::Origin::kFactory && message.stroke_count == 48u && message.speed_cdeg_s == 52942u && message.crc == 27910u && message.end_us == 188597584u && message.generation == 2843033353u;
}

static const uint8_t kPayloadManeuverInfoReply[] = {0x00, 0x30, 0xCE, 0xCE, 0x06, 0x6D, 0x50, 0xC5, 0x3D, 0x0B, 0x09, 0x3F, 0x75, 0xA9};
static const uint8_t kFrameManeuverInfoReply[] = {0x03, 0x93, 0x0F, 0x10, 0x30, 0xCE, 0xCE, 0x06, 0x6D, 0x50, 0xC5, 0x3D, 0x0B, 0x09, 0x3F, 0x75, 0xA9, 0x83, 0x61, 0x00};

inline size_t build_ManeuverReadRequest(uint8_t* payload) {
  protocol::ManeuverReadRequest message;
  message.index = 71u;
  message.encode(payload);
  return protocol::ManeuverReadRequest::kSize;
}

inline bool matches_ManeuverReadRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverReadRequest message;
  if (!message.decode(payload, size)) return false;
  return message.index == 71u;
}

static const uint8_t kPayloadManeuverReadRequest[] = {0x47};
static const uint8_t kFrameManeuverReadRequest[] = {0x06, 0x14, 0x10, 0x47, 0x6F, 0x68, 0x00};

inline size_t build_ManeuverReadReply(uint8_t* payload) {
  protocol::ManeuverReadReply message;
  message.index = 229u;
  message.joint = 132u;
  message.angle_cdeg = 8787;
  message.start_us = 3230310313u;
  message.encode(payload);
  return protocol::ManeuverReadReply::kSize;
}

inline bool matches_ManeuverReadReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.index == 229u && message.joint == 132u && message.angle_cdeg == 8787 && message.start_us == 3230310313u;
}

static const uint8_t kPayloadManeuverReadReply[] = {0xE5, 0x84, 0x53, 0x22, 0xA9, 0x9F, 0x8A, 0xC0};
static const uint8_t kFrameManeuverReadReply[] = {0x0D, 0x94, 0x11, 0xE5, 0x84, 0x53, 0x22, 0xA9, 0x9F, 0x8A, 0xC0, 0x9E, 0x44, 0x00};

inline size_t build_ArmRequest(uint8_t* payload) {
  protocol::ArmRequest message;
  message.arm_token = 24258u;
  message.encode(payload);
  return protocol::ArmRequest::kSize;
}

inline bool matches_ArmRequest(const uint8_t* payload, size_t size) {
  protocol::ArmRequest message;
  if (!message.decode(payload, size)) return false;
  return message.arm_token == 24258u;
}

static const uint8_t kPayloadArmRequest[] = {0xC2, 0x5E};
static const uint8_t kFrameArmRequest[] = {0x07, 0x20, 0x12, 0xC2, 0x5E, 0x80, 0x55, 0x00};

inline size_t build_ArmReply(uint8_t* payload) {
  protocol::ArmReply message;
  message.state = protocol::SequencerState::kRunning;
  message.encode(payload);
  return protocol::ArmReply::kSize;
}

inline bool matches_ArmReply(const uint8_t* payload, size_t size) {
  protocol::ArmReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kRunning;
}

static const uint8_t kPayloadArmReply[] = {0x02};
static const uint8_t kFrameArmReply[] = {0x06, 0xA0, 0x13, 0x02, 0x62, 0x07, 0x00};

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
  message.state = protocol::SequencerState::kDone;
  message.encode(payload);
  return protocol::DisarmReply::kSize;
}

inline bool matches_DisarmReply(const uint8_t* payload, size_t size) {
  protocol::DisarmReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kDone;
}

static const uint8_t kPayloadDisarmReply[] = {0x03};
static const uint8_t kFrameDisarmReply[] = {0x06, 0xA1, 0x15, 0x03, 0xD5, 0x8A, 0x00};

inline size_t build_RecordStartRequest(uint8_t* payload) {
  protocol::RecordStartRequest message;
  message.number = 963151503u;
  message.unix_us = 15537419026778854196ull;
  message.encode(payload);
  return protocol::RecordStartRequest::kSize;
}

inline bool matches_RecordStartRequest(const uint8_t* payload, size_t size) {
  protocol::RecordStartRequest message;
  if (!message.decode(payload, size)) return false;
  return message.number == 963151503u && message.unix_us == 15537419026778854196ull;
}

static const uint8_t kPayloadRecordStartRequest[] = {0x8F, 0x86, 0x68, 0x39, 0x34, 0x93, 0x8C, 0xB9, 0x48, 0x00, 0xA0, 0xD7};
static const uint8_t kFrameRecordStartRequest[] = {0x0C, 0x40, 0x16, 0x8F, 0x86, 0x68, 0x39, 0x34, 0x93, 0x8C, 0xB9, 0x48, 0x05, 0xA0, 0xD7, 0x1F, 0xF4, 0x00};

inline size_t build_RecordStartReply(uint8_t* payload) {
  protocol::RecordStartReply message;
  message.state = protocol::LoggerState::kFailed;
  message.session = 336524219u;
  message.encode(payload);
  return protocol::RecordStartReply::kSize;
}

inline bool matches_RecordStartReply(const uint8_t* payload, size_t size) {
  protocol::RecordStartReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kFailed && message.session == 336524219u;
}

static const uint8_t kPayloadRecordStartReply[] = {0x04, 0xBB, 0xF3, 0x0E, 0x14};
static const uint8_t kFrameRecordStartReply[] = {0x0A, 0xC0, 0x17, 0x04, 0xBB, 0xF3, 0x0E, 0x14, 0x6E, 0xF8, 0x00};

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
  message.session = 1350428462u;
  message.samples = 4004864232u;
  message.samples_dropped = 2364332705u;
  message.encode(payload);
  return protocol::RecordStopReply::kSize;
}

inline bool matches_RecordStopReply(const uint8_t* payload, size_t size) {
  protocol::RecordStopReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kRecording && message.session == 1350428462u && message.samples == 4004864232u && message.samples_dropped == 2364332705u;
}

static const uint8_t kPayloadRecordStopReply[] = {0x01, 0x2E, 0xE7, 0x7D, 0x50, 0xE8, 0x60, 0xB5, 0xEE, 0xA1, 0xDA, 0xEC, 0x8C};
static const uint8_t kFrameRecordStopReply[] = {0x12, 0xC1, 0x19, 0x01, 0x2E, 0xE7, 0x7D, 0x50, 0xE8, 0x60, 0xB5, 0xEE, 0xA1, 0xDA, 0xEC, 0x8C, 0x15, 0x4C, 0x00};

inline size_t build_LiveRequest(uint8_t* payload) {
  protocol::LiveRequest message;
  message.enabled = 43u;
  message.encode(payload);
  return protocol::LiveRequest::kSize;
}

inline bool matches_LiveRequest(const uint8_t* payload, size_t size) {
  protocol::LiveRequest message;
  if (!message.decode(payload, size)) return false;
  return message.enabled == 43u;
}

static const uint8_t kPayloadLiveRequest[] = {0x2B};
static const uint8_t kFrameLiveRequest[] = {0x06, 0x42, 0x1A, 0x2B, 0xE0, 0xC6, 0x00};

inline size_t build_LiveReply(uint8_t* payload) {
  protocol::LiveReply message;
  message.enabled = 201u;
  message.rate_hz = 26515u;
  message.gyro_lsb_per_deg_s = 192.375f;
  message.accel_lsb_per_g = 129.6875f;
  message.angle_counts_per_turn = 1111078138u;
  message.imu_offset_us[0] = 57457u;
  message.imu_offset_us[1] = 32424u;
  message.imu_offset_us[2] = 7392u;
  message.imu_offset_us[3] = 47895u;
  message.angle_offset_us[0] = 22863u;
  message.angle_offset_us[1] = 63366u;
  message.angle_offset_us[2] = 38334u;
  message.angle_offset_us[3] = 13301u;
  message.angle_offset_us[4] = 53804u;
  message.angle_offset_us[5] = 28772u;
  message.encode(payload);
  return protocol::LiveReply::kSize;
}

inline bool matches_LiveReply(const uint8_t* payload, size_t size) {
  protocol::LiveReply message;
  if (!message.decode(payload, size)) return false;
  return message.enabled == 201u && message.rate_hz == 26515u && message.gyro_lsb_per_deg_s == 192.375f && message.accel_lsb_per_g == 129.6875f && message.angle_counts_per_turn == 1111078138u && message.imu_offset_us[0] == 57457u && message.imu_offset_us[1] == 32424u && message.imu_offset_us[2] == 7392u && message.imu_offset_us[3] == 47895u && message.angle_offset_us[0] == 22863u && message.angle_offset_us[1] == 63366u && message.angle_offset_us[2] == 38334u && message.angle_offset_us[3] == 13301u && message.angle_offset_us[4] == 53804u && message.angle_offset_us[5] == 28772u;
}

static const uint8_t kPayloadLiveReply[] = {0xC9, 0x93, 0x67, 0x00, 0x60, 0x40, 0x43, 0x00, 0xB0, 0x01, 0x43, 0xFA, 0xB4, 0x39, 0x42, 0x71, 0xE0, 0xA8, 0x7E, 0xE0, 0x1C, 0x17, 0xBB, 0x4F, 0x59, 0x86, 0xF7, 0xBE, 0x95, 0xF5, 0x33, 0x2C, 0xD2, 0x64, 0x70};
static const uint8_t kFrameLiveReply[] = {0x06, 0xC2, 0x1B, 0xC9, 0x93, 0x67, 0x04, 0x60, 0x40, 0x43, 0x1E, 0xB0, 0x01, 0x43, 0xFA, 0xB4, 0x39, 0x42, 0x71, 0xE0, 0xA8, 0x7E, 0xE0, 0x1C, 0x17, 0xBB, 0x4F, 0x59, 0x86, 0xF7, 0xBE, 0x95, 0xF5, 0x33, 0x2C, 0xD2, 0x64, 0x70, 0x1D, 0x54, 0x00};

inline size_t build_LoggerSettingsWriteRequest(uint8_t* payload) {
  protocol::LoggerSettingsWriteRequest message;
  message.settings.rate_hz = 44243u;
  message.settings.gyro_range_deg_s = 19210u;
  message.settings.accel_range_g = 233u;
  message.settings.dlpf_cfg = 135u;
  message.settings.bus_khz = 9649u;
  message.settings.after_landing_s = 50152u;
  message.settings.file_mib = 25120u;
  message.encode(payload);
  return protocol::LoggerSettingsWriteRequest::kSize;
}

inline bool matches_LoggerSettingsWriteRequest(const uint8_t* payload, size_t size) {
  protocol::LoggerSettingsWriteRequest message;
  if (!message.decode(payload, size)) return false;
  return message.settings.rate_hz == 44243u && message.settings.gyro_range_deg_s == 19210u && message.settings.accel_range_g == 233u && message.settings.dlpf_cfg == 135u && message.settings.bus_khz == 9649u && message.settings.after_landing_s == 50152u && message.settings.file_mib == 25120u;
}

static const uint8_t kPayloadLoggerSettingsWriteRequest[] = {0xD3, 0xAC, 0x0A, 0x4B, 0xE9, 0x87, 0xB1, 0x25, 0xE8, 0xC3, 0x20, 0x62};
static const uint8_t kFrameLoggerSettingsWriteRequest[] = {0x11, 0x45, 0x1C, 0xD3, 0xAC, 0x0A, 0x4B, 0xE9, 0x87, 0xB1, 0x25, 0xE8, 0xC3, 0x20, 0x62, 0x28, 0x7C, 0x00};

inline size_t build_LoggerSettingsWriteReply(uint8_t* payload) {
  protocol::LoggerSettingsWriteReply message;
  message.stored = 0u;
  message.encode(payload);
  return protocol::LoggerSettingsWriteReply::kSize;
}

inline bool matches_LoggerSettingsWriteReply(const uint8_t* payload, size_t size) {
  protocol::LoggerSettingsWriteReply message;
  if (!message.decode(payload, size)) return false;
  return message.stored == 0u;
}

static const uint8_t kPayloadLoggerSettingsWriteReply[] = {0x00};
static const uint8_t kFrameLoggerSettingsWriteReply[] = {0x03, 0xC5, 0x1D, 0x03, 0xB4, 0x74, 0x00};

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
  message.settings.rate_hz = 56062u;
  message.settings.gyro_range_deg_s = 31029u;
  message.settings.accel_range_g = 23u;
  message.settings.dlpf_cfg = 181u;
  message.settings.bus_khz = 21468u;
  message.settings.after_landing_s = 61971u;
  message.settings.file_mib = 36939u;
  message.rate_max_hz = 11906u;
  message.encode(payload);
  return protocol::LoggerSettingsReadReply::kSize;
}

inline bool matches_LoggerSettingsReadReply(const uint8_t* payload, size_t size) {
  protocol::LoggerSettingsReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.origin == protocol::Origin::kUploaded && message.settings.rate_hz == 56062u && message.settings.gyro_range_deg_s == 31029u && message.settings.accel_range_g == 23u && message.settings.dlpf_cfg == 181u && message.settings.bus_khz == 21468u && message.settings.after_landing_s == 61971u && message.settings.file_mib == 36939u && message.rate_max_hz == 11906u;
}

static const uint8_t kPayloadLoggerSettingsReadReply[] = {0x01, 0xFE, 0xDA, 0x35, 0x79, 0x17, 0xB5, 0xDC, 0x53, 0x13, 0xF2, 0x4B, 0x90, 0x82, 0x2E};
static const uint8_t kFrameLoggerSettingsReadReply[] = {0x14, 0xC6, 0x1F, 0x01, 0xFE, 0xDA, 0x35, 0x79, 0x17, 0xB5, 0xDC, 0x53, 0x13, 0xF2, 0x4B, 0x90, 0x82, 0x2E, 0xE3, 0x4E, 0x00};

inline size_t build_ClockSetRequest(uint8_t* payload) {
  protocol::ClockSetRequest message;
  message.unix_us = 14752095521904848550ull;
  message.encode(payload);
  return protocol::ClockSetRequest::kSize;
}

inline bool matches_ClockSetRequest(const uint8_t* payload, size_t size) {
  protocol::ClockSetRequest message;
  if (!message.decode(payload, size)) return false;
  return message.unix_us == 14752095521904848550ull;
}

static const uint8_t kPayloadClockSetRequest[] = {0xA6, 0xEE, 0xC4, 0x9B, 0xB7, 0xF8, 0xB9, 0xCC};
static const uint8_t kFrameClockSetRequest[] = {0x0D, 0x47, 0x20, 0xA6, 0xEE, 0xC4, 0x9B, 0xB7, 0xF8, 0xB9, 0xCC, 0xD2, 0x20, 0x00};

inline size_t build_ClockSetReply(uint8_t* payload) {
  protocol::ClockSetReply message;
  message.uptime_us = 7706066267518495419ull;
  message.encode(payload);
  return protocol::ClockSetReply::kSize;
}

inline bool matches_ClockSetReply(const uint8_t* payload, size_t size) {
  protocol::ClockSetReply message;
  if (!message.decode(payload, size)) return false;
  return message.uptime_us == 7706066267518495419ull;
}

static const uint8_t kPayloadClockSetReply[] = {0xBB, 0x6A, 0x0F, 0x1B, 0x71, 0x72, 0xF1, 0x6A};
static const uint8_t kFrameClockSetReply[] = {0x0D, 0xC7, 0x21, 0xBB, 0x6A, 0x0F, 0x1B, 0x71, 0x72, 0xF1, 0x6A, 0x87, 0x48, 0x00};

inline size_t build_LogListRequest(uint8_t* payload) {
  protocol::LogListRequest message;
  message.from_number = 2344u;
  message.encode(payload);
  return protocol::LogListRequest::kSize;
}

inline bool matches_LogListRequest(const uint8_t* payload, size_t size) {
  protocol::LogListRequest message;
  if (!message.decode(payload, size)) return false;
  return message.from_number == 2344u;
}

static const uint8_t kPayloadLogListRequest[] = {0x28, 0x09};
static const uint8_t kFrameLogListRequest[] = {0x07, 0x48, 0x22, 0x28, 0x09, 0x5F, 0x99, 0x00};

inline size_t build_LogListReply(uint8_t* payload) {
  protocol::LogListReply message;
  message.found = 167u;
  message.entry.number = 58319u;
  message.entry.session = 2181485328u;
  message.entry.blocks = 540953802u;
  message.entry.wall_clock_us = 13724093707942678350ull;
  message.entry.closed = 92u;
  message.encode(payload);
  return protocol::LogListReply::kSize;
}

inline bool matches_LogListReply(const uint8_t* payload, size_t size) {
  protocol::LogListReply message;
  if (!message.decode(payload, size)) return false;
  return message.found == 167u && message.entry.number == 58319u && message.entry.session == 2181485328u && message.entry.blocks == 540953802u && message.entry.wall_clock_us == 13724093707942678350ull && message.entry.closed == 92u;
}

static const uint8_t kPayloadLogListReply[] = {0xA7, 0xCF, 0xE3, 0x10, 0xD3, 0x06, 0x82, 0xCA, 0x4C, 0x3E, 0x20, 0x4E, 0xCF, 0x18, 0x96, 0x83, 0xC6, 0x75, 0xBE, 0x5C};
static const uint8_t kFrameLogListReply[] = {0x19, 0xC8, 0x23, 0xA7, 0xCF, 0xE3, 0x10, 0xD3, 0x06, 0x82, 0xCA, 0x4C, 0x3E, 0x20, 0x4E, 0xCF, 0x18, 0x96, 0x83, 0xC6, 0x75, 0xBE, 0x5C, 0x97, 0x2B, 0x00};

inline size_t build_LogReadRequest(uint8_t* payload) {
  protocol::LogReadRequest message;
  message.number = 64228u;
  message.session = 2568762288u;
  message.first_block = 928230761u;
  message.count = 54667u;
  message.encode(payload);
  return protocol::LogReadRequest::kSize;
}

inline bool matches_LogReadRequest(const uint8_t* payload, size_t size) {
  protocol::LogReadRequest message;
  if (!message.decode(payload, size)) return false;
  return message.number == 64228u && message.session == 2568762288u && message.first_block == 928230761u && message.count == 54667u;
}

static const uint8_t kPayloadLogReadRequest[] = {0xE4, 0xFA, 0xB0, 0x33, 0x1C, 0x99, 0x69, 0xAD, 0x53, 0x37, 0x8B, 0xD5};
static const uint8_t kFrameLogReadRequest[] = {0x11, 0x49, 0x24, 0xE4, 0xFA, 0xB0, 0x33, 0x1C, 0x99, 0x69, 0xAD, 0x53, 0x37, 0x8B, 0xD5, 0xA2, 0xFB, 0x00};

inline size_t build_LogReadReply(uint8_t* payload) {
  protocol::LogReadReply message;
  message.count = 29634u;
  message.encode(payload);
  return protocol::LogReadReply::kSize;
}

inline bool matches_LogReadReply(const uint8_t* payload, size_t size) {
  protocol::LogReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.count == 29634u;
}

static const uint8_t kPayloadLogReadReply[] = {0xC2, 0x73};
static const uint8_t kFrameLogReadReply[] = {0x07, 0xC9, 0x25, 0xC2, 0x73, 0xE7, 0x97, 0x00};

inline size_t build_LogEraseRequest(uint8_t* payload) {
  protocol::LogEraseRequest message;
  message.number = 4602u;
  message.session = 2956039247u;
  message.encode(payload);
  return protocol::LogEraseRequest::kSize;
}

inline bool matches_LogEraseRequest(const uint8_t* payload, size_t size) {
  protocol::LogEraseRequest message;
  if (!message.decode(payload, size)) return false;
  return message.number == 4602u && message.session == 2956039247u;
}

static const uint8_t kPayloadLogEraseRequest[] = {0xFA, 0x11, 0x4F, 0x94, 0x31, 0xB0};
static const uint8_t kFrameLogEraseRequest[] = {0x09, 0x4A, 0x26, 0xFA, 0x11, 0x4F, 0x94, 0x31, 0xB0, 0x02, 0xAF, 0x00};

inline size_t build_LogEraseReply(uint8_t* payload) {
  protocol::LogEraseReply message;
  message.erased = 78u;
  message.encode(payload);
  return protocol::LogEraseReply::kSize;
}

inline bool matches_LogEraseReply(const uint8_t* payload, size_t size) {
  protocol::LogEraseReply message;
  if (!message.decode(payload, size)) return false;
  return message.erased == 78u;
}

static const uint8_t kPayloadLogEraseReply[] = {0x4E};
static const uint8_t kFrameLogEraseReply[] = {0x06, 0xCA, 0x27, 0x4E, 0xD1, 0x1B, 0x00};

inline size_t build_LogPartStream(uint8_t* payload) {
  protocol::LogPartStream message;
  message.block = 3969943490u;
  message.part = 138u;
  message.data[0] = 41u;
  message.data[1] = 199u;
  message.data[2] = 101u;
  message.data[3] = 3u;
  message.data[4] = 161u;
  message.data[5] = 64u;
  message.data[6] = 222u;
  message.data[7] = 124u;
  message.data[8] = 26u;
  message.data[9] = 185u;
  message.data[10] = 87u;
  message.data[11] = 245u;
  message.data[12] = 147u;
  message.data[13] = 49u;
  message.data[14] = 208u;
  message.data[15] = 110u;
  message.data[16] = 12u;
  message.data[17] = 170u;
  message.data[18] = 72u;
  message.data[19] = 231u;
  message.data[20] = 133u;
  message.data[21] = 35u;
  message.data[22] = 193u;
  message.data[23] = 96u;
  message.data[24] = 254u;
  message.data[25] = 156u;
  message.data[26] = 58u;
  message.data[27] = 216u;
  message.data[28] = 119u;
  message.data[29] = 21u;
  message.data[30] = 179u;
  message.data[31] = 81u;
  message.data[32] = 239u;
  message.data[33] = 142u;
  message.data[34] = 44u;
  message.data[35] = 202u;
  message.data[36] = 104u;
  message.data[37] = 7u;
  message.data[38] = 165u;
  message.data[39] = 67u;
  message.data[40] = 225u;
  message.data[41] = 127u;
  message.data[42] = 30u;
  message.data[43] = 188u;
  message.data[44] = 90u;
  message.data[45] = 248u;
  message.data[46] = 151u;
  message.data[47] = 53u;
  message.data[48] = 211u;
  message.data[49] = 113u;
  message.data[50] = 15u;
  message.data[51] = 174u;
  message.data[52] = 76u;
  message.data[53] = 234u;
  message.data[54] = 136u;
  message.data[55] = 38u;
  message.data[56] = 197u;
  message.data[57] = 99u;
  message.data[58] = 1u;
  message.data[59] = 159u;
  message.data[60] = 62u;
  message.data[61] = 220u;
  message.data[62] = 122u;
  message.data[63] = 24u;
  message.encode(payload);
  return protocol::LogPartStream::kSize;
}

inline bool matches_LogPartStream(const uint8_t* payload, size_t size) {
  protocol::LogPartStream message;
  if (!message.decode(payload, size)) return false;
  return message.block == 3969943490u && message.part == 138u && message.data[0] == 41u && message.data[1] == 199u && message.data[2] == 101u && message.data[3] == 3u && message.data[4] == 161u && message.data[5] == 64u && message.data[6] == 222u && message.data[7] == 124u && message.data[8] == 26u && message.data[9] == 185u && message.data[10] == 87u && message.data[11] == 245u && message.data[12] == 147u && message.data[13] == 49u && message.data[14] == 208u && message.data[15] == 110u && message.data[16] == 12u && message.data[17] == 170u && message.data[18] == 72u && message.data[19] == 231u && message.data[20] == 133u && message.data[21] == 35u && message.data[22] == 193u && message.data[23] == 96u && message.data[24] == 254u && message.data[25] == 156u && message.data[26] == 58u && message.data[27] == 216u && message.data[28] == 119u && message.data[29] == 21u && message.data[30] == 179u && message.data[31] == 81u && message.data[32] == 239u && message.data[33] == 142u && message.data[34] == 44u && message.data[35] == 202u && message.data[36] == 104u && message.data[37] == 7u && message.data[38] == 165u && message.data[39] == 67u && message.data[40] == 225u && message.data[41] == 127u && message.data[42] == 30u && message.data[43] == 188u && message.data[44] == 90u && message.data[45] == 248u && message.data[46] == 151u && message.data[47] == 53u && message.data[48] == 211u && message.data[49] == 113u && message.data[50] == 15u && message.data[51] == 174u && message.data[52] == 76u && message.data[53] == 234u && message.data[54] == 136u && message.data[55] == 38u && message.data[56] == 197u && message.data[57] == 99u && message.data[58] == 1u && message.data[59] == 159u && message.data[60] == 62u && message.data[61] == 220u && message.data[62] == 122u && message.data[63] == 24u;
}

static const uint8_t kPayloadLogPartStream[] = {0xC2, 0x87, 0xA0, 0xEC, 0x8A, 0x29, 0xC7, 0x65, 0x03, 0xA1, 0x40, 0xDE, 0x7C, 0x1A, 0xB9, 0x57, 0xF5, 0x93, 0x31, 0xD0, 0x6E, 0x0C, 0xAA, 0x48, 0xE7, 0x85, 0x23, 0xC1, 0x60, 0xFE, 0x9C, 0x3A, 0xD8, 0x77, 0x15, 0xB3, 0x51, 0xEF, 0x8E, 0x2C, 0xCA, 0x68, 0x07, 0xA5, 0x43, 0xE1, 0x7F, 0x1E, 0xBC, 0x5A, 0xF8, 0x97, 0x35, 0xD3, 0x71, 0x0F, 0xAE, 0x4C, 0xEA, 0x88, 0x26, 0xC5, 0x63, 0x01, 0x9F, 0x3E, 0xDC, 0x7A, 0x18};
static const uint8_t kFrameLogPartStream[] = {0x4A, 0x61, 0x28, 0xC2, 0x87, 0xA0, 0xEC, 0x8A, 0x29, 0xC7, 0x65, 0x03, 0xA1, 0x40, 0xDE, 0x7C, 0x1A, 0xB9, 0x57, 0xF5, 0x93, 0x31, 0xD0, 0x6E, 0x0C, 0xAA, 0x48, 0xE7, 0x85, 0x23, 0xC1, 0x60, 0xFE, 0x9C, 0x3A, 0xD8, 0x77, 0x15, 0xB3, 0x51, 0xEF, 0x8E, 0x2C, 0xCA, 0x68, 0x07, 0xA5, 0x43, 0xE1, 0x7F, 0x1E, 0xBC, 0x5A, 0xF8, 0x97, 0x35, 0xD3, 0x71, 0x0F, 0xAE, 0x4C, 0xEA, 0x88, 0x26, 0xC5, 0x63, 0x01, 0x9F, 0x3E, 0xDC, 0x7A, 0x18, 0xF1, 0xF1, 0x00};

inline size_t build_LogZerosStream(uint8_t* payload) {
  protocol::LogZerosStream message;
  message.first_block = 3069045141u;
  message.count = 21797u;
  message.encode(payload);
  return protocol::LogZerosStream::kSize;
}

inline bool matches_LogZerosStream(const uint8_t* payload, size_t size) {
  protocol::LogZerosStream message;
  if (!message.decode(payload, size)) return false;
  return message.first_block == 3069045141u && message.count == 21797u;
}

static const uint8_t kPayloadLogZerosStream[] = {0x95, 0xE9, 0xED, 0xB6, 0x25, 0x55};
static const uint8_t kFrameLogZerosStream[] = {0x0B, 0x62, 0x29, 0x95, 0xE9, 0xED, 0xB6, 0x25, 0x55, 0xBF, 0x6A, 0x00};

inline size_t build_LiveSampleStream(uint8_t* payload) {
  protocol::LiveSampleStream message;
  message.index = 4082949384u;
  message.time_us = 10490104822707329481ull;
  message.sample.time_offset_us = 3456322100u;
  message.sample.flags = 27706u;
  message.sample.imu[0].accel[0] = -22359;
  message.sample.imu[0].accel[1] = 18145;
  message.sample.imu[0].accel[2] = -6888;
  message.sample.imu[0].temperature = -31920;
  message.sample.imu[0].gyro[0] = 8583;
  message.sample.imu[0].gyro[1] = -16449;
  message.sample.imu[0].gyro[2] = 24054;
  message.sample.imu[1].accel[0] = -26011;
  message.sample.imu[1].accel[1] = 14492;
  message.sample.imu[1].accel[2] = -10540;
  message.sample.imu[1].temperature = 29963;
  message.sample.imu[1].gyro[0] = 4931;
  message.sample.imu[1].gyro[1] = -20102;
  message.sample.imu[1].gyro[2] = 20402;
  message.sample.imu[2].accel[0] = -29663;
  message.sample.imu[2].accel[1] = 10840;
  message.sample.imu[2].accel[2] = -14192;
  message.sample.imu[2].temperature = 26311;
  message.sample.imu[2].gyro[0] = 1279;
  message.sample.imu[2].gyro[1] = -23754;
  message.sample.imu[2].gyro[2] = 16750;
  message.sample.imu[3].accel[0] = 32221;
  message.sample.imu[3].accel[1] = 7188;
  message.sample.imu[3].accel[2] = -17844;
  message.sample.imu[3].temperature = 22659;
  message.sample.imu[3].gyro[0] = -2373;
  message.sample.imu[3].gyro[1] = -27406;
  message.sample.imu[3].gyro[2] = 13097;
  message.sample.angle[0] = 53601u;
  message.sample.angle[1] = 28568u;
  message.sample.angle[2] = 3536u;
  message.sample.angle[3] = 44039u;
  message.sample.angle[4] = 19007u;
  message.sample.angle[5] = 59510u;
  message.encode(payload);
  return protocol::LiveSampleStream::kSize;
}

inline bool matches_LiveSampleStream(const uint8_t* payload, size_t size) {
  protocol::LiveSampleStream message;
  if (!message.decode(payload, size)) return false;
  return message.index == 4082949384u && message.time_us == 10490104822707329481ull && message.sample.time_offset_us == 3456322100u && message.sample.flags == 27706u && message.sample.imu[0].accel[0] == -22359 && message.sample.imu[0].accel[1] == 18145 && message.sample.imu[0].accel[2] == -6888 && message.sample.imu[0].temperature == -31920 && message.sample.imu[0].gyro[0] == 8583 && message.sample.imu[0].gyro[1] == -16449 && message.sample.imu[0].gyro[2] == 24054 && message.sample.imu[1].accel[0] == -26011 && message.sample.imu[1].accel[1] == 14492 && message.sample.imu[1].accel[2] == -10540 && message.sample.imu[1].temperature == 29963 && message.sample.imu[1].gyro[0] == 4931 && message.sample.imu[1].gyro[1] == -20102 && message.sample.imu[1].gyro[2] == 20402 && message.sample.imu[2].accel[0] == -29663 && message.sample.imu[2].accel[1] == 10840 && message.sample.imu[2].accel[2] == -14192 && message.sample.imu[2].temperature == 26311 && message.sample.imu[2].gyro[0] == 1279 && message.sample.imu[2].gyro[1] == -23754 && message.sample.imu[2].gyro[2] == 16750 && message.sample.imu[3].accel[0] == 32221 && message.sample.imu[3].accel[1] == 7188 && message.sample.imu[3].accel[2] == -17844 && message.sample.imu[3].temperature == 22659 && message.sample.imu[3].gyro[0] == -2373 && message.sample.imu[3].gyro[1] == -27406 && message.sample.imu[3].gyro[2] == 13097 && message.sample.angle[0] == 53601u && message.sample.angle[1] == 28568u && message.sample.angle[2] == 3536u && message.sample.angle[3] == 44039u && message.sample.angle[4] == 19007u && message.sample.angle[5] == 59510u;
}

static const uint8_t kPayloadLiveSampleStream[] = {0x08, 0xDD, 0x5C, 0xF3, 0xC9, 0x19, 0x15, 0xDE, 0xC1, 0x56, 0x94, 0x91, 0x34, 0x4A, 0x03, 0xCE, 0x3A, 0x6C, 0xA9, 0xA8, 0xE1, 0x46, 0x18, 0xE5, 0x50, 0x83, 0x87, 0x21, 0xBF, 0xBF, 0xF6, 0x5D, 0x65, 0x9A, 0x9C, 0x38, 0xD4, 0xD6, 0x0B, 0x75, 0x43, 0x13, 0x7A, 0xB1, 0xB2, 0x4F, 0x21, 0x8C, 0x58, 0x2A, 0x90, 0xC8, 0xC7, 0x66, 0xFF, 0x04, 0x36, 0xA3, 0x6E, 0x41, 0xDD, 0x7D, 0x14, 0x1C, 0x4C, 0xBA, 0x83, 0x58, 0xBB, 0xF6, 0xF2, 0x94, 0x29, 0x33, 0x61, 0xD1, 0x98, 0x6F, 0xD0, 0x0D, 0x07, 0xAC, 0x3F, 0x4A, 0x76, 0xE8};
static const uint8_t kFrameLiveSampleStream[] = {0x5B, 0x60, 0x2A, 0x08, 0xDD, 0x5C, 0xF3, 0xC9, 0x19, 0x15, 0xDE, 0xC1, 0x56, 0x94, 0x91, 0x34, 0x4A, 0x03, 0xCE, 0x3A, 0x6C, 0xA9, 0xA8, 0xE1, 0x46, 0x18, 0xE5, 0x50, 0x83, 0x87, 0x21, 0xBF, 0xBF, 0xF6, 0x5D, 0x65, 0x9A, 0x9C, 0x38, 0xD4, 0xD6, 0x0B, 0x75, 0x43, 0x13, 0x7A, 0xB1, 0xB2, 0x4F, 0x21, 0x8C, 0x58, 0x2A, 0x90, 0xC8, 0xC7, 0x66, 0xFF, 0x04, 0x36, 0xA3, 0x6E, 0x41, 0xDD, 0x7D, 0x14, 0x1C, 0x4C, 0xBA, 0x83, 0x58, 0xBB, 0xF6, 0xF2, 0x94, 0x29, 0x33, 0x61, 0xD1, 0x98, 0x6F, 0xD0, 0x0D, 0x07, 0xAC, 0x3F, 0x4A, 0x76, 0xE8, 0x9F, 0xF4, 0x00};

inline size_t build_ErrorReply(uint8_t* payload) {
  protocol::ErrorReply message;
  message.request = 134u;
  message.code = protocol::ErrorCode::kRamHoldsDrop;
  message.detail = -1021492573;
  message.encode(payload);
  return protocol::ErrorReply::kSize;
}

inline bool matches_ErrorReply(const uint8_t* payload, size_t size) {
  protocol::ErrorReply message;
  if (!message.decode(payload, size)) return false;
  return message.request == 134u && message.code == protocol::ErrorCode::kRamHoldsDrop && message.detail == -1021492573;
}

static const uint8_t kPayloadErrorReply[] = {0x86, 0x36, 0xA3, 0x42, 0x1D, 0xC3};
static const uint8_t kFrameErrorReply[] = {0x0B, 0xFF, 0x2B, 0x86, 0x36, 0xA3, 0x42, 0x1D, 0xC3, 0x65, 0x86, 0x00};

inline size_t build_SettingsWriteRequest(uint8_t* payload) {
  protocol::SettingsWriteRequest message;
  message.frame_us = 24916u;
  message.servo[0].zero_us = 40387u;
  message.servo[0].ns_per_deg = 15355u;
  message.servo[0].reversed = 218u;
  message.servo[0].min_cdeg = 30826;
  message.servo[0].max_cdeg = 5793;
  message.servo[1].zero_us = 21264u;
  message.servo[1].ns_per_deg = 61768u;
  message.servo[1].reversed = 143u;
  message.servo[1].min_cdeg = 11702;
  message.servo[1].max_cdeg = -13330;
  message.servo[2].zero_us = 2141u;
  message.servo[2].ns_per_deg = 42644u;
  message.servo[2].reversed = 68u;
  message.servo[2].min_cdeg = -7421;
  message.servo[2].max_cdeg = -32453;
  message.encode(payload);
  return protocol::SettingsWriteRequest::kSize;
}

inline bool matches_SettingsWriteRequest(const uint8_t* payload, size_t size) {
  protocol::SettingsWriteRequest message;
  if (!message.decode(payload, size)) return false;
  return message.frame_us == 24916u && message.servo[0].zero_us == 40387u && message.servo[0].ns_per_deg == 15355u && message.servo[0].reversed == 218u && message.servo[0].min_cdeg == 30826 && message.servo[0].max_cdeg == 5793 && message.servo[1].zero_us == 21264u && message.servo[1].ns_per_deg == 61768u && message.servo[1].reversed == 143u && message.servo[1].min_cdeg == 11702 && message.servo[1].max_cdeg == -13330 && message.servo[2].zero_us == 2141u && message.servo[2].ns_per_deg == 42644u && message.servo[2].reversed == 68u && message.servo[2].min_cdeg == -7421 && message.servo[2].max_cdeg == -32453;
}

static const uint8_t kPayloadSettingsWriteRequest[] = {0x54, 0x61, 0xC3, 0x9D, 0xFB, 0x3B, 0xDA, 0x6A, 0x78, 0xA1, 0x16, 0x10, 0x53, 0x48, 0xF1, 0x8F, 0xB6, 0x2D, 0xEE, 0xCB, 0x5D, 0x08, 0x94, 0xA6, 0x44, 0x03, 0xE3, 0x3B, 0x81};
static const uint8_t kFrameSettingsWriteRequest[] = {0x22, 0x15, 0x2C, 0x54, 0x61, 0xC3, 0x9D, 0xFB, 0x3B, 0xDA, 0x6A, 0x78, 0xA1, 0x16, 0x10, 0x53, 0x48, 0xF1, 0x8F, 0xB6, 0x2D, 0xEE, 0xCB, 0x5D, 0x08, 0x94, 0xA6, 0x44, 0x03, 0xE3, 0x3B, 0x81, 0x10, 0x49, 0x00};

inline size_t build_SettingsWriteReply(uint8_t* payload) {
  protocol::SettingsWriteReply message;
  message.stored = 31u;
  message.written = 189u;
  message.encode(payload);
  return protocol::SettingsWriteReply::kSize;
}

inline bool matches_SettingsWriteReply(const uint8_t* payload, size_t size) {
  protocol::SettingsWriteReply message;
  if (!message.decode(payload, size)) return false;
  return message.stored == 31u && message.written == 189u;
}

static const uint8_t kPayloadSettingsWriteReply[] = {0x1F, 0xBD};
static const uint8_t kFrameSettingsWriteReply[] = {0x07, 0x95, 0x2D, 0x1F, 0xBD, 0xB6, 0x5F, 0x00};

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
  message.origin = protocol::Origin::kFactory;
  message.generation = 4195955278u;
  message.frame_us = 38992u;
  message.servo[0].zero_us = 54463u;
  message.servo[0].ns_per_deg = 29431u;
  message.servo[0].reversed = 17u;
  message.servo[0].min_cdeg = -20634;
  message.servo[0].max_cdeg = 19869;
  message.servo[1].zero_us = 35340u;
  message.servo[1].ns_per_deg = 10307u;
  message.servo[1].reversed = 198u;
  message.servo[1].min_cdeg = 25778;
  message.servo[1].max_cdeg = 746;
  message.servo[2].zero_us = 16217u;
  message.servo[2].ns_per_deg = 56720u;
  message.servo[2].reversed = 123u;
  message.servo[2].min_cdeg = 6655;
  message.servo[2].max_cdeg = -18377;
  message.encode(payload);
  return protocol::SettingsReadReply::kSize;
}

inline bool matches_SettingsReadReply(const uint8_t* payload, size_t size) {
  protocol::SettingsReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.origin == protocol::Origin::kFactory && message.generation == 4195955278u && message.frame_us == 38992u && message.servo[0].zero_us == 54463u && message.servo[0].ns_per_deg == 29431u && message.servo[0].reversed == 17u && message.servo[0].min_cdeg == -20634 && message.servo[0].max_cdeg == 19869 && message.servo[1].zero_us == 35340u && message.servo[1].ns_per_deg == 10307u && message.servo[1].reversed == 198u && message.servo[1].min_cdeg == 25778 && message.servo[1].max_cdeg == 746 && message.servo[2].zero_us == 16217u && message.servo[2].ns_per_deg == 56720u && message.servo[2].reversed == 123u && message.servo[2].min_cdeg == 6655 && message.servo[2].max_cdeg == -18377;
}

static const uint8_t kPayloadSettingsReadReply[] = {0x00, 0x4E, 0x32, 0x19, 0xFA, 0x50, 0x98, 0xBF, 0xD4, 0xF7, 0x72, 0x11, 0x66, 0xAF, 0x9D, 0x4D, 0x0C, 0x8A, 0x43, 0x28, 0xC6, 0xB2, 0x64, 0xEA, 0x02, 0x59, 0x3F, 0x90, 0xDD, 0x7B, 0xFF, 0x19, 0x37, 0xB8};
static const uint8_t kFrameSettingsReadReply[] = {0x03, 0x96, 0x2F, 0x24, 0x4E, 0x32, 0x19, 0xFA, 0x50, 0x98, 0xBF, 0xD4, 0xF7, 0x72, 0x11, 0x66, 0xAF, 0x9D, 0x4D, 0x0C, 0x8A, 0x43, 0x28, 0xC6, 0xB2, 0x64, 0xEA, 0x02, 0x59, 0x3F, 0x90, 0xDD, 0x7B, 0xFF, 0x19, 0x37, 0xB8, 0x96, 0x69, 0x00};

inline size_t build_JointReportRequest(uint8_t* payload) {
  protocol::JointReportRequest message;
  message.angle_cdeg[0] = 22126;
  message.angle_cdeg[1] = -2906;
  message.angle_cdeg[2] = -27939;
  message.encode(payload);
  return protocol::JointReportRequest::kSize;
}

inline bool matches_JointReportRequest(const uint8_t* payload, size_t size) {
  protocol::JointReportRequest message;
  if (!message.decode(payload, size)) return false;
  return message.angle_cdeg[0] == 22126 && message.angle_cdeg[1] == -2906 && message.angle_cdeg[2] == -27939;
}

static const uint8_t kPayloadJointReportRequest[] = {0x6E, 0x56, 0xA6, 0xF4, 0xDD, 0x92};
static const uint8_t kFrameJointReportRequest[] = {0x0B, 0x22, 0x30, 0x6E, 0x56, 0xA6, 0xF4, 0xDD, 0x92, 0x8C, 0xA9, 0x00};

inline size_t build_JointReportReply(uint8_t* payload) {
  protocol::JointReportReply message;
  message.at_start_pose = 49u;
  message.encode(payload);
  return protocol::JointReportReply::kSize;
}

inline bool matches_JointReportReply(const uint8_t* payload, size_t size) {
  protocol::JointReportReply message;
  if (!message.decode(payload, size)) return false;
  return message.at_start_pose == 49u;
}

static const uint8_t kPayloadJointReportReply[] = {0x31};
static const uint8_t kFrameJointReportReply[] = {0x06, 0xA2, 0x31, 0x31, 0xB6, 0x0F, 0x00};

inline size_t build_JogRequest(uint8_t* payload) {
  protocol::JogRequest message;
  message.joint = 207u;
  message.from_cdeg = 28036;
  message.to_cdeg = 3003;
  message.confirm = 2851277022u;
  message.encode(payload);
  return protocol::JogRequest::kSize;
}

inline bool matches_JogRequest(const uint8_t* payload, size_t size) {
  protocol::JogRequest message;
  if (!message.decode(payload, size)) return false;
  return message.joint == 207u && message.from_cdeg == 28036 && message.to_cdeg == 3003 && message.confirm == 2851277022u;
}

static const uint8_t kPayloadJogRequest[] = {0xCF, 0x84, 0x6D, 0xBB, 0x0B, 0xDE, 0x08, 0xF3, 0xA9};
static const uint8_t kFrameJogRequest[] = {0x0E, 0x23, 0x32, 0xCF, 0x84, 0x6D, 0xBB, 0x0B, 0xDE, 0x08, 0xF3, 0xA9, 0x05, 0xB3, 0x00};

inline size_t build_JogReply(uint8_t* payload) {
  protocol::JogReply message;
  message.angle_cdeg = 18474;
  message.arrived = 230u;
  message.encode(payload);
  return protocol::JogReply::kSize;
}

inline bool matches_JogReply(const uint8_t* payload, size_t size) {
  protocol::JogReply message;
  if (!message.decode(payload, size)) return false;
  return message.angle_cdeg == 18474 && message.arrived == 230u;
}

static const uint8_t kPayloadJogReply[] = {0x2A, 0x48, 0xE6};
static const uint8_t kFrameJogReply[] = {0x08, 0xA3, 0x33, 0x2A, 0x48, 0xE6, 0x05, 0x3A, 0x00};

static const Vector kVectors[] = {
    {"HelloRequest", protocol::HelloRequest::kType, 0, build_HelloRequest, matches_HelloRequest, kPayloadHelloRequest, 0, kFrameHelloRequest, 6},
    {"HelloReply", protocol::HelloReply::kType, 1, build_HelloReply, matches_HelloReply, kPayloadHelloReply, 24, kFrameHelloReply, 30},
    {"SequencerStatusRequest", protocol::SequencerStatusRequest::kType, 2, build_SequencerStatusRequest, matches_SequencerStatusRequest, kPayloadSequencerStatusRequest, 0, kFrameSequencerStatusRequest, 6},
    {"SequencerStatusReply", protocol::SequencerStatusReply::kType, 3, build_SequencerStatusReply, matches_SequencerStatusReply, kPayloadSequencerStatusReply, 33, kFrameSequencerStatusReply, 39},
    {"RunReportRequest", protocol::RunReportRequest::kType, 4, build_RunReportRequest, matches_RunReportRequest, kPayloadRunReportRequest, 0, kFrameRunReportRequest, 6},
    {"RunReportReply", protocol::RunReportReply::kType, 5, build_RunReportReply, matches_RunReportReply, kPayloadRunReportReply, 82, kFrameRunReportReply, 88},
    {"LoggerStatusRequest", protocol::LoggerStatusRequest::kType, 6, build_LoggerStatusRequest, matches_LoggerStatusRequest, kPayloadLoggerStatusRequest, 0, kFrameLoggerStatusRequest, 6},
    {"LoggerStatusReply", protocol::LoggerStatusReply::kType, 7, build_LoggerStatusReply, matches_LoggerStatusReply, kPayloadLoggerStatusReply, 54, kFrameLoggerStatusReply, 60},
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
    {"RecordStartRequest", protocol::RecordStartRequest::kType, 22, build_RecordStartRequest, matches_RecordStartRequest, kPayloadRecordStartRequest, 12, kFrameRecordStartRequest, 18},
    {"RecordStartReply", protocol::RecordStartReply::kType, 23, build_RecordStartReply, matches_RecordStartReply, kPayloadRecordStartReply, 5, kFrameRecordStartReply, 11},
    {"RecordStopRequest", protocol::RecordStopRequest::kType, 24, build_RecordStopRequest, matches_RecordStopRequest, kPayloadRecordStopRequest, 0, kFrameRecordStopRequest, 6},
    {"RecordStopReply", protocol::RecordStopReply::kType, 25, build_RecordStopReply, matches_RecordStopReply, kPayloadRecordStopReply, 13, kFrameRecordStopReply, 19},
    {"LiveRequest", protocol::LiveRequest::kType, 26, build_LiveRequest, matches_LiveRequest, kPayloadLiveRequest, 1, kFrameLiveRequest, 7},
    {"LiveReply", protocol::LiveReply::kType, 27, build_LiveReply, matches_LiveReply, kPayloadLiveReply, 35, kFrameLiveReply, 41},
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
    {"SettingsWriteRequest", protocol::SettingsWriteRequest::kType, 44, build_SettingsWriteRequest, matches_SettingsWriteRequest, kPayloadSettingsWriteRequest, 29, kFrameSettingsWriteRequest, 35},
    {"SettingsWriteReply", protocol::SettingsWriteReply::kType, 45, build_SettingsWriteReply, matches_SettingsWriteReply, kPayloadSettingsWriteReply, 2, kFrameSettingsWriteReply, 8},
    {"SettingsReadRequest", protocol::SettingsReadRequest::kType, 46, build_SettingsReadRequest, matches_SettingsReadRequest, kPayloadSettingsReadRequest, 0, kFrameSettingsReadRequest, 6},
    {"SettingsReadReply", protocol::SettingsReadReply::kType, 47, build_SettingsReadReply, matches_SettingsReadReply, kPayloadSettingsReadReply, 34, kFrameSettingsReadReply, 40},
    {"JointReportRequest", protocol::JointReportRequest::kType, 48, build_JointReportRequest, matches_JointReportRequest, kPayloadJointReportRequest, 6, kFrameJointReportRequest, 12},
    {"JointReportReply", protocol::JointReportReply::kType, 49, build_JointReportReply, matches_JointReportReply, kPayloadJointReportReply, 1, kFrameJointReportReply, 7},
    {"JogRequest", protocol::JogRequest::kType, 50, build_JogRequest, matches_JogRequest, kPayloadJogRequest, 9, kFrameJogRequest, 15},
    {"JogReply", protocol::JogReply::kType, 51, build_JogReply, matches_JogReply, kPayloadJogReply, 3, kFrameJogReply, 9},
};

}  // namespace golden
}  // namespace tfsat

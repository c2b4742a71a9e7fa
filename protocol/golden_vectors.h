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
  message.encode(payload);
  return protocol::SequencerStatusReply::kSize;
}

inline bool matches_SequencerStatusReply(const uint8_t* payload, size_t size) {
  protocol::SequencerStatusReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kFault && message.fault == protocol::ErrorCode::kResetWhileRunning && message.last_refusal == protocol::ErrorCode::kJogNotConfirmed && message.switches_open == 116u && message.arm_token == 4805u && message.reset_cause == protocol::ResetCause::kBrownOut && message.resets_while_armed == 79u && message.strokes_started == 237u && message.knocks == 35747u && message.joint_angle_cdeg[0] == 10715 && message.joint_angle_cdeg[1] == -14318 && message.joint_angle_cdeg[2] == 26185 && message.uptime_ms == 75591690u && message.image_crc == 2730027459u && message.ram_never_used_bytes == 16624u && message.frames_rejected == 57127u && message.stores_damaged == 125u;
}

static const uint8_t kPayloadSequencerStatusReply[] = {0x04, 0x17, 0x18, 0x74, 0xC5, 0x12, 0x02, 0x4F, 0xED, 0xA3, 0x8B, 0xDB, 0x29, 0x12, 0xC8, 0x49, 0x66, 0x0A, 0x70, 0x81, 0x04, 0xC3, 0xE9, 0xB8, 0xA2, 0xF0, 0x40, 0x27, 0xDF, 0x7D};
static const uint8_t kFrameSequencerStatusReply[] = {0x23, 0x82, 0x03, 0x04, 0x17, 0x18, 0x74, 0xC5, 0x12, 0x02, 0x4F, 0xED, 0xA3, 0x8B, 0xDB, 0x29, 0x12, 0xC8, 0x49, 0x66, 0x0A, 0x70, 0x81, 0x04, 0xC3, 0xE9, 0xB8, 0xA2, 0xF0, 0x40, 0x27, 0xDF, 0x7D, 0x27, 0xB1, 0x00};

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
  message.released = 27u;
  message.bounces = 47566u;
  message.release_ms = 1476772892u;
  message.release_us = 63037u;
  message.stroke_count = 148u;
  message.start_us[0] = 850145609u;
  message.start_us[1] = 3504581378u;
  message.start_us[2] = 1864049852u;
  message.start_us[3] = 223518325u;
  message.start_us[4] = 2877954095u;
  message.start_us[5] = 1237422568u;
  message.start_us[6] = 3891858338u;
  message.start_us[7] = 2251326811u;
  message.start_us[8] = 610795285u;
  message.start_us[9] = 3265231054u;
  message.start_us[10] = 1624699528u;
  message.start_us[11] = 4279135297u;
  message.start_us[12] = 2638603771u;
  message.start_us[13] = 998072244u;
  message.start_us[14] = 3652508014u;
  message.start_us[15] = 2011976487u;
  message.encode(payload);
  return protocol::RunReportReply::kSize;
}

inline bool matches_RunReportReply(const uint8_t* payload, size_t size) {
  protocol::RunReportReply message;
  if (!message.decode(payload, size)) return false;
  return message.released == 27u && message.bounces == 47566u && message.release_ms == 1476772892u && message.release_us == 63037u && message.stroke_count == 148u && message.start_us[0] == 850145609u && message.start_us[1] == 3504581378u && message.start_us[2] == 1864049852u && message.start_us[3] == 223518325u && message.start_us[4] == 2877954095u && message.start_us[5] == 1237422568u && message.start_us[6] == 3891858338u && message.start_us[7] == 2251326811u && message.start_us[8] == 610795285u && message.start_us[9] == 3265231054u && message.start_us[10] == 1624699528u && message.start_us[11] == 4279135297u && message.start_us[12] == 2638603771u && message.start_us[13] == 998072244u && message.start_us[14] == 3652508014u && message.start_us[15] == 2011976487u;
}

static const uint8_t kPayloadRunReportReply[] = {0x1B, 0xCE, 0xB9, 0x1C, 0xC4, 0x05, 0x58, 0x3D, 0xF6, 0x94, 0x49, 0x31, 0xAC, 0x32, 0x02, 0xAB, 0xE3, 0xD0, 0xBC, 0x24, 0x1B, 0x6F, 0x75, 0x9E, 0x52, 0x0D, 0x2F, 0x18, 0x8A, 0xAB, 0xE8, 0x91, 0xC1, 0x49, 0xA2, 0x0B, 0xF9, 0xE7, 0x5B, 0x85, 0x30, 0x86, 0x15, 0xFF, 0x67, 0x24, 0xCE, 0x78, 0x9F, 0xC2, 0x88, 0xF2, 0xD6, 0x60, 0x41, 0x6C, 0x0E, 0xFF, 0xFB, 0xE5, 0x45, 0x9D, 0xB4, 0x5F, 0x7D, 0x3B, 0x6E, 0xD9, 0xB4, 0xD9, 0x27, 0x53, 0xEC, 0x77};
static const uint8_t kFrameRunReportReply[] = {0x4F, 0x84, 0x05, 0x1B, 0xCE, 0xB9, 0x1C, 0xC4, 0x05, 0x58, 0x3D, 0xF6, 0x94, 0x49, 0x31, 0xAC, 0x32, 0x02, 0xAB, 0xE3, 0xD0, 0xBC, 0x24, 0x1B, 0x6F, 0x75, 0x9E, 0x52, 0x0D, 0x2F, 0x18, 0x8A, 0xAB, 0xE8, 0x91, 0xC1, 0x49, 0xA2, 0x0B, 0xF9, 0xE7, 0x5B, 0x85, 0x30, 0x86, 0x15, 0xFF, 0x67, 0x24, 0xCE, 0x78, 0x9F, 0xC2, 0x88, 0xF2, 0xD6, 0x60, 0x41, 0x6C, 0x0E, 0xFF, 0xFB, 0xE5, 0x45, 0x9D, 0xB4, 0x5F, 0x7D, 0x3B, 0x6E, 0xD9, 0xB4, 0xD9, 0x27, 0x53, 0xEC, 0x77, 0x3E, 0x4A, 0x00};

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
  message.error = protocol::ErrorCode::kStoreDamaged;
  message.imu_present = 82u;
  message.switches_open = 240u;
  message.session = 2399253447u;
  message.samples = 758721920u;
  message.samples_dropped = 3413157690u;
  message.blocks_written = 1772626163u;
  message.ring_blocks = 2015u;
  message.ring_peak_blocks = 42519u;
  message.rate_hz = 17486u;
  message.who_am_i[0] = 226u;
  message.who_am_i[1] = 128u;
  message.who_am_i[2] = 30u;
  message.who_am_i[3] = 189u;
  message.uptime_ms = 1533275839u;
  message.encode(payload);
  return protocol::LoggerStatusReply::kSize;
}

inline bool matches_LoggerStatusReply(const uint8_t* payload, size_t size) {
  protocol::LoggerStatusReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kIdle && message.error == protocol::ErrorCode::kStoreDamaged && message.imu_present == 82u && message.switches_open == 240u && message.session == 2399253447u && message.samples == 758721920u && message.samples_dropped == 3413157690u && message.blocks_written == 1772626163u && message.ring_blocks == 2015u && message.ring_peak_blocks == 42519u && message.rate_hz == 17486u && message.who_am_i[0] == 226u && message.who_am_i[1] == 128u && message.who_am_i[2] == 30u && message.who_am_i[3] == 189u && message.uptime_ms == 1533275839u;
}

static const uint8_t kPayloadLoggerStatusReply[] = {0x00, 0x1B, 0x52, 0xF0, 0xC7, 0xB3, 0x01, 0x8F, 0x80, 0x2D, 0x39, 0x2D, 0x3A, 0xA7, 0x70, 0xCB, 0xF3, 0x20, 0xA8, 0x69, 0xDF, 0x07, 0x17, 0xA6, 0x4E, 0x44, 0xE2, 0x80, 0x1E, 0xBD, 0xBF, 0xEE, 0x63, 0x5B};
static const uint8_t kFrameLoggerStatusReply[] = {0x03, 0x83, 0x07, 0x24, 0x1B, 0x52, 0xF0, 0xC7, 0xB3, 0x01, 0x8F, 0x80, 0x2D, 0x39, 0x2D, 0x3A, 0xA7, 0x70, 0xCB, 0xF3, 0x20, 0xA8, 0x69, 0xDF, 0x07, 0x17, 0xA6, 0x4E, 0x44, 0xE2, 0x80, 0x1E, 0xBD, 0xBF, 0xEE, 0x63, 0x5B, 0xAC, 0x21, 0x00};

inline size_t build_ManeuverBeginRequest(uint8_t* payload) {
  protocol::ManeuverBeginRequest message;
  message.stroke_count = 249u;
  message.speed_cdeg_s = 38866u;
  message.encode(payload);
  return protocol::ManeuverBeginRequest::kSize;
}

inline bool matches_ManeuverBeginRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverBeginRequest message;
  if (!message.decode(payload, size)) return false;
  return message.stroke_count == 249u && message.speed_cdeg_s == 38866u;
}

static const uint8_t kPayloadManeuverBeginRequest[] = {0xF9, 0xD2, 0x97};
static const uint8_t kFrameManeuverBeginRequest[] = {0x08, 0x10, 0x08, 0xF9, 0xD2, 0x97, 0x4D, 0x6D, 0x00};

inline size_t build_ManeuverBeginReply(uint8_t* payload) {
  protocol::ManeuverBeginReply message;
  message.stroke_count = 54u;
  message.encode(payload);
  return protocol::ManeuverBeginReply::kSize;
}

inline bool matches_ManeuverBeginReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverBeginReply message;
  if (!message.decode(payload, size)) return false;
  return message.stroke_count == 54u;
}

static const uint8_t kPayloadManeuverBeginReply[] = {0x36};
static const uint8_t kFrameManeuverBeginReply[] = {0x06, 0x90, 0x09, 0x36, 0xA8, 0x58, 0x00};

inline size_t build_ManeuverStrokeRequest(uint8_t* payload) {
  protocol::ManeuverStrokeRequest message;
  message.index = 212u;
  message.joint = 114u;
  message.angle_cdeg = 4272;
  message.start_us = 2934457042u;
  message.encode(payload);
  return protocol::ManeuverStrokeRequest::kSize;
}

inline bool matches_ManeuverStrokeRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverStrokeRequest message;
  if (!message.decode(payload, size)) return false;
  return message.index == 212u && message.joint == 114u && message.angle_cdeg == 4272 && message.start_us == 2934457042u;
}

static const uint8_t kPayloadManeuverStrokeRequest[] = {0xD4, 0x72, 0xB0, 0x10, 0xD2, 0x42, 0xE8, 0xAE};
static const uint8_t kFrameManeuverStrokeRequest[] = {0x0D, 0x11, 0x0A, 0xD4, 0x72, 0xB0, 0x10, 0xD2, 0x42, 0xE8, 0xAE, 0x17, 0x2C, 0x00};

inline size_t build_ManeuverStrokeReply(uint8_t* payload) {
  protocol::ManeuverStrokeReply message;
  message.index = 77u;
  message.encode(payload);
  return protocol::ManeuverStrokeReply::kSize;
}

inline bool matches_ManeuverStrokeReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverStrokeReply message;
  if (!message.decode(payload, size)) return false;
  return message.index == 77u;
}

static const uint8_t kPayloadManeuverStrokeReply[] = {0x4D};
static const uint8_t kFrameManeuverStrokeReply[] = {0x06, 0x91, 0x0B, 0x4D, 0x06, 0xC6, 0x00};

inline size_t build_ManeuverCommitRequest(uint8_t* payload) {
  protocol::ManeuverCommitRequest message;
  message.crc = 60247u;
  message.encode(payload);
  return protocol::ManeuverCommitRequest::kSize;
}

inline bool matches_ManeuverCommitRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverCommitRequest message;
  if (!message.decode(payload, size)) return false;
  return message.crc == 60247u;
}

static const uint8_t kPayloadManeuverCommitRequest[] = {0x57, 0xEB};
static const uint8_t kFrameManeuverCommitRequest[] = {0x07, 0x12, 0x0C, 0x57, 0xEB, 0x03, 0xDC, 0x00};

inline size_t build_ManeuverCommitReply(uint8_t* payload) {
  protocol::ManeuverCommitReply message;
  message.stored = 137u;
  message.written = 39u;
  message.encode(payload);
  return protocol::ManeuverCommitReply::kSize;
}

inline bool matches_ManeuverCommitReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverCommitReply message;
  if (!message.decode(payload, size)) return false;
  return message.stored == 137u && message.written == 39u;
}

static const uint8_t kPayloadManeuverCommitReply[] = {0x89, 0x27};
static const uint8_t kFrameManeuverCommitReply[] = {0x07, 0x92, 0x0D, 0x89, 0x27, 0xE3, 0x18, 0x00};

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
  message.stroke_count = 100u;
  message.speed_cdeg_s = 620u;
  message.crc = 41124u;
  message.end_us = 1054575191u;
  message.generation = 3709010961u;
  message.encode(payload);
  return protocol::ManeuverInfoReply::kSize;
}

inline bool matches_ManeuverInfoReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverInfoReply message;
  if (!message.decode(payload, size)) return false;
  return message.origin == protocol::Origin::kUploaded && message.stroke_count == 100u && message.speed_cdeg_s == 620u && message.crc == 41124u && message.end_us == 1054575191u && message.generation == 3709010961u;
}

static const uint8_t kPayloadManeuverInfoReply[] = {0x01, 0x64, 0x6C, 0x02, 0xA4, 0xA0, 0x57, 0x8A, 0xDB, 0x3E, 0x11, 0x04, 0x13, 0xDD};
static const uint8_t kFrameManeuverInfoReply[] = {0x13, 0x93, 0x0F, 0x01, 0x64, 0x6C, 0x02, 0xA4, 0xA0, 0x57, 0x8A, 0xDB, 0x3E, 0x11, 0x04, 0x13, 0xDD, 0x4F, 0x9F, 0x00};

inline size_t build_ManeuverReadRequest(uint8_t* payload) {
  protocol::ManeuverReadRequest message;
  message.index = 123u;
  message.encode(payload);
  return protocol::ManeuverReadRequest::kSize;
}

inline bool matches_ManeuverReadRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverReadRequest message;
  if (!message.decode(payload, size)) return false;
  return message.index == 123u;
}

static const uint8_t kPayloadManeuverReadRequest[] = {0x7B};
static const uint8_t kFrameManeuverReadRequest[] = {0x06, 0x14, 0x10, 0x7B, 0xB0, 0x9F, 0x00};

inline size_t build_ManeuverReadReply(uint8_t* payload) {
  protocol::ManeuverReadReply message;
  message.index = 25u;
  message.joint = 183u;
  message.angle_cdeg = 22000;
  message.start_us = 4096287920u;
  message.encode(payload);
  return protocol::ManeuverReadReply::kSize;
}

inline bool matches_ManeuverReadReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.index == 25u && message.joint == 183u && message.angle_cdeg == 22000 && message.start_us == 4096287920u;
}

static const uint8_t kPayloadManeuverReadReply[] = {0x19, 0xB7, 0xF0, 0x55, 0xB0, 0x64, 0x28, 0xF4};
static const uint8_t kFrameManeuverReadReply[] = {0x0D, 0x94, 0x11, 0x19, 0xB7, 0xF0, 0x55, 0xB0, 0x64, 0x28, 0xF4, 0x89, 0x3A, 0x00};

inline size_t build_ArmRequest(uint8_t* payload) {
  protocol::ArmRequest message;
  message.arm_token = 37471u;
  message.encode(payload);
  return protocol::ArmRequest::kSize;
}

inline bool matches_ArmRequest(const uint8_t* payload, size_t size) {
  protocol::ArmRequest message;
  if (!message.decode(payload, size)) return false;
  return message.arm_token == 37471u;
}

static const uint8_t kPayloadArmRequest[] = {0x5F, 0x92};
static const uint8_t kFrameArmRequest[] = {0x07, 0x20, 0x12, 0x5F, 0x92, 0xF7, 0x23, 0x00};

inline size_t build_ArmReply(uint8_t* payload) {
  protocol::ArmReply message;
  message.state = protocol::SequencerState::kDone;
  message.encode(payload);
  return protocol::ArmReply::kSize;
}

inline bool matches_ArmReply(const uint8_t* payload, size_t size) {
  protocol::ArmReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kDone;
}

static const uint8_t kPayloadArmReply[] = {0x03};
static const uint8_t kFrameArmReply[] = {0x06, 0xA0, 0x13, 0x03, 0x43, 0x17, 0x00};

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
  message.state = protocol::SequencerState::kFault;
  message.encode(payload);
  return protocol::DisarmReply::kSize;
}

inline bool matches_DisarmReply(const uint8_t* payload, size_t size) {
  protocol::DisarmReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kFault;
}

static const uint8_t kPayloadDisarmReply[] = {0x04};
static const uint8_t kFrameDisarmReply[] = {0x06, 0xA1, 0x15, 0x04, 0x32, 0xFA, 0x00};

inline size_t build_RecordStartRequest(uint8_t* payload) {
  protocol::RecordStartRequest message;
  message.number = 1829129110u;
  message.encode(payload);
  return protocol::RecordStartRequest::kSize;
}

inline bool matches_RecordStartRequest(const uint8_t* payload, size_t size) {
  protocol::RecordStartRequest message;
  if (!message.decode(payload, size)) return false;
  return message.number == 1829129110u;
}

static const uint8_t kPayloadRecordStartRequest[] = {0x96, 0x4B, 0x06, 0x6D};
static const uint8_t kFrameRecordStartRequest[] = {0x09, 0x40, 0x16, 0x96, 0x4B, 0x06, 0x6D, 0x28, 0xB6, 0x00};

inline size_t build_RecordStartReply(uint8_t* payload) {
  protocol::RecordStartReply message;
  message.state = protocol::LoggerState::kStopping;
  message.session = 2843033353u;
  message.encode(payload);
  return protocol::RecordStartReply::kSize;
}

inline bool matches_RecordStartReply(const uint8_t* payload, size_t size) {
  protocol::RecordStartReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kStopping && message.session == 2843033353u;
}

static const uint8_t kPayloadRecordStartReply[] = {0x02, 0x09, 0x3F, 0x75, 0xA9};
static const uint8_t kFrameRecordStartReply[] = {0x0A, 0xC0, 0x17, 0x02, 0x09, 0x3F, 0x75, 0xA9, 0x11, 0xD8, 0x00};

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
  message.state = protocol::LoggerState::kFailed;
  message.session = 3856937596u;
  message.samples = 2216406070u;
  message.samples_dropped = 575874543u;
  message.encode(payload);
  return protocol::RecordStopReply::kSize;
}

inline bool matches_RecordStopReply(const uint8_t* payload, size_t size) {
  protocol::RecordStopReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kFailed && message.session == 3856937596u && message.samples == 2216406070u && message.samples_dropped == 575874543u;
}

static const uint8_t kPayloadRecordStopReply[] = {0x04, 0x7C, 0x32, 0xE4, 0xE5, 0x36, 0xAC, 0x1B, 0x84, 0xEF, 0x25, 0x53, 0x22};
static const uint8_t kFrameRecordStopReply[] = {0x12, 0xC1, 0x19, 0x04, 0x7C, 0x32, 0xE4, 0xE5, 0x36, 0xAC, 0x1B, 0x84, 0xEF, 0x25, 0x53, 0x22, 0x7C, 0x73, 0x00};

inline size_t build_LiveRequest(uint8_t* payload) {
  protocol::LiveRequest message;
  message.enabled = 192u;
  message.encode(payload);
  return protocol::LiveRequest::kSize;
}

inline bool matches_LiveRequest(const uint8_t* payload, size_t size) {
  protocol::LiveRequest message;
  if (!message.decode(payload, size)) return false;
  return message.enabled == 192u;
}

static const uint8_t kPayloadLiveRequest[] = {0xC0};
static const uint8_t kFrameLiveRequest[] = {0x06, 0x42, 0x1A, 0xC0, 0xA5, 0x8A, 0x00};

inline size_t build_LiveReply(uint8_t* payload) {
  protocol::LiveReply message;
  message.enabled = 94u;
  message.rate_hz = 64761u;
  message.gyro_lsb_per_deg_s = 176.625f;
  message.accel_lsb_per_g = 113.9375f;
  message.angle_counts_per_turn = 3617587272u;
  message.encode(payload);
  return protocol::LiveReply::kSize;
}

inline bool matches_LiveReply(const uint8_t* payload, size_t size) {
  protocol::LiveReply message;
  if (!message.decode(payload, size)) return false;
  return message.enabled == 94u && message.rate_hz == 64761u && message.gyro_lsb_per_deg_s == 176.625f && message.accel_lsb_per_g == 113.9375f && message.angle_counts_per_turn == 3617587272u;
}

static const uint8_t kPayloadLiveReply[] = {0x5E, 0xF9, 0xFC, 0x00, 0xA0, 0x30, 0x43, 0x00, 0xE0, 0xE3, 0x42, 0x48, 0x00, 0xA0, 0xD7};
static const uint8_t kFrameLiveReply[] = {0x06, 0xC2, 0x1B, 0x5E, 0xF9, 0xFC, 0x04, 0xA0, 0x30, 0x43, 0x05, 0xE0, 0xE3, 0x42, 0x48, 0x05, 0xA0, 0xD7, 0x5E, 0xF5, 0x00};

inline size_t build_LiveSampleStream(uint8_t* payload) {
  protocol::LiveSampleStream message;
  message.index = 1977055746u;
  message.time_us = 1445360518006147934ull;
  message.sample.time_offset_us = 1350428462u;
  message.sample.flags = 61109u;
  message.sample.imu[0].accel[0] = 11044;
  message.sample.imu[0].accel[1] = -13989;
  message.sample.imu[0].accel[2] = 26515;
  message.sample.imu[0].temperature = 1482;
  message.sample.imu[0].gyro[0] = -23550;
  message.sample.imu[0].gyro[1] = 16953;
  message.sample.imu[0].gyro[2] = -8079;
  message.sample.imu[1].accel[0] = 7392;
  message.sample.imu[1].accel[1] = -17641;
  message.sample.imu[1].accel[2] = 22863;
  message.sample.imu[1].temperature = -2170;
  message.sample.imu[1].gyro[0] = -27202;
  message.sample.imu[1].gyro[1] = 13301;
  message.sample.imu[1].gyro[2] = -11732;
  message.sample.imu[2].accel[0] = 3739;
  message.sample.imu[2].accel[1] = -21293;
  message.sample.imu[2].accel[2] = 19210;
  message.sample.imu[2].temperature = -5822;
  message.sample.imu[2].gyro[0] = -30855;
  message.sample.imu[2].gyro[1] = 9649;
  message.sample.imu[2].gyro[2] = -15384;
  message.sample.imu[3].accel[0] = 87;
  message.sample.imu[3].accel[1] = -24945;
  message.sample.imu[3].accel[2] = 15558;
  message.sample.imu[3].temperature = -9474;
  message.sample.imu[3].gyro[0] = 31029;
  message.sample.imu[3].gyro[1] = 5997;
  message.sample.imu[3].gyro[2] = -19036;
  message.sample.angle[0] = 21468u;
  message.sample.angle[1] = 61971u;
  message.sample.angle[2] = 36939u;
  message.sample.angle[3] = 11906u;
  message.sample.angle[4] = 52409u;
  message.sample.angle[5] = 27377u;
  message.encode(payload);
  return protocol::LiveSampleStream::kSize;
}

inline bool matches_LiveSampleStream(const uint8_t* payload, size_t size) {
  protocol::LiveSampleStream message;
  if (!message.decode(payload, size)) return false;
  return message.index == 1977055746u && message.time_us == 1445360518006147934ull && message.sample.time_offset_us == 1350428462u && message.sample.flags == 61109u && message.sample.imu[0].accel[0] == 11044 && message.sample.imu[0].accel[1] == -13989 && message.sample.imu[0].accel[2] == 26515 && message.sample.imu[0].temperature == 1482 && message.sample.imu[0].gyro[0] == -23550 && message.sample.imu[0].gyro[1] == 16953 && message.sample.imu[0].gyro[2] == -8079 && message.sample.imu[1].accel[0] == 7392 && message.sample.imu[1].accel[1] == -17641 && message.sample.imu[1].accel[2] == 22863 && message.sample.imu[1].temperature == -2170 && message.sample.imu[1].gyro[0] == -27202 && message.sample.imu[1].gyro[1] == 13301 && message.sample.imu[1].gyro[2] == -11732 && message.sample.imu[2].accel[0] == 3739 && message.sample.imu[2].accel[1] == -21293 && message.sample.imu[2].accel[2] == 19210 && message.sample.imu[2].temperature == -5822 && message.sample.imu[2].gyro[0] == -30855 && message.sample.imu[2].gyro[1] == 9649 && message.sample.imu[2].gyro[2] == -15384 && message.sample.imu[3].accel[0] == 87 && message.sample.imu[3].accel[1] == -24945 && message.sample.imu[3].accel[2] == 15558 && message.sample.imu[3].temperature == -9474 && message.sample.imu[3].gyro[0] == 31029 && message.sample.imu[3].gyro[1] == 5997 && message.sample.imu[3].gyro[2] == -19036 && message.sample.angle[0] == 21468u && message.sample.angle[1] == 61971u && message.sample.angle[2] == 36939u && message.sample.angle[3] == 11906u && message.sample.angle[4] == 52409u && message.sample.angle[5] == 27377u;
}

static const uint8_t kPayloadLiveSampleStream[] = {0x02, 0x7A, 0xD7, 0x75, 0x5E, 0x8B, 0x21, 0xB8, 0xBB, 0xF3, 0x0E, 0x14, 0x2E, 0xE7, 0x7D, 0x50, 0xB5, 0xEE, 0x24, 0x2B, 0x5B, 0xC9, 0x93, 0x67, 0xCA, 0x05, 0x02, 0xA4, 0x39, 0x42, 0x71, 0xE0, 0xE0, 0x1C, 0x17, 0xBB, 0x4F, 0x59, 0x86, 0xF7, 0xBE, 0x95, 0xF5, 0x33, 0x2C, 0xD2, 0x9B, 0x0E, 0xD3, 0xAC, 0x0A, 0x4B, 0x42, 0xE9, 0x79, 0x87, 0xB1, 0x25, 0xE8, 0xC3, 0x57, 0x00, 0x8F, 0x9E, 0xC6, 0x3C, 0xFE, 0xDA, 0x35, 0x79, 0x6D, 0x17, 0xA4, 0xB5, 0xDC, 0x53, 0x13, 0xF2, 0x4B, 0x90, 0x82, 0x2E, 0xB9, 0xCC, 0xF1, 0x6A};
static const uint8_t kFrameLiveSampleStream[] = {0x40, 0x60, 0x1C, 0x02, 0x7A, 0xD7, 0x75, 0x5E, 0x8B, 0x21, 0xB8, 0xBB, 0xF3, 0x0E, 0x14, 0x2E, 0xE7, 0x7D, 0x50, 0xB5, 0xEE, 0x24, 0x2B, 0x5B, 0xC9, 0x93, 0x67, 0xCA, 0x05, 0x02, 0xA4, 0x39, 0x42, 0x71, 0xE0, 0xE0, 0x1C, 0x17, 0xBB, 0x4F, 0x59, 0x86, 0xF7, 0xBE, 0x95, 0xF5, 0x33, 0x2C, 0xD2, 0x9B, 0x0E, 0xD3, 0xAC, 0x0A, 0x4B, 0x42, 0xE9, 0x79, 0x87, 0xB1, 0x25, 0xE8, 0xC3, 0x57, 0x1B, 0x8F, 0x9E, 0xC6, 0x3C, 0xFE, 0xDA, 0x35, 0x79, 0x6D, 0x17, 0xA4, 0xB5, 0xDC, 0x53, 0x13, 0xF2, 0x4B, 0x90, 0x82, 0x2E, 0xB9, 0xCC, 0xF1, 0x6A, 0x9E, 0x7F, 0x00};

inline size_t build_ErrorReply(uint8_t* payload) {
  protocol::ErrorReply message;
  message.request = 9u;
  message.code = protocol::ErrorCode::kResetWhileArmed;
  message.detail = 1167581085;
  message.encode(payload);
  return protocol::ErrorReply::kSize;
}

inline bool matches_ErrorReply(const uint8_t* payload, size_t size) {
  protocol::ErrorReply message;
  if (!message.decode(payload, size)) return false;
  return message.request == 9u && message.code == protocol::ErrorCode::kResetWhileArmed && message.detail == 1167581085;
}

static const uint8_t kPayloadErrorReply[] = {0x09, 0x16, 0x9D, 0xDF, 0x97, 0x45};
static const uint8_t kFrameErrorReply[] = {0x0B, 0xFF, 0x1D, 0x09, 0x16, 0x9D, 0xDF, 0x97, 0x45, 0x9C, 0xD6, 0x00};

inline size_t build_SettingsWriteRequest(uint8_t* payload) {
  protocol::SettingsWriteRequest message;
  message.frame_us = 58319u;
  message.servo[0].zero_us = 8254u;
  message.servo[0].ns_per_deg = 48757u;
  message.servo[0].reversed = 92u;
  message.servo[0].min_cdeg = -1308;
  message.servo[0].max_cdeg = -26340;
  message.servo[1].zero_us = 54667u;
  message.servo[1].ns_per_deg = 29634u;
  message.servo[1].reversed = 17u;
  message.servo[1].min_cdeg = -20431;
  message.servo[1].max_cdeg = 20073;
  message.servo[2].zero_us = 35544u;
  message.servo[2].ns_per_deg = 10511u;
  message.servo[2].reversed = 199u;
  message.servo[2].min_cdeg = 25982;
  message.servo[2].max_cdeg = 949;
  message.encode(payload);
  return protocol::SettingsWriteRequest::kSize;
}

inline bool matches_SettingsWriteRequest(const uint8_t* payload, size_t size) {
  protocol::SettingsWriteRequest message;
  if (!message.decode(payload, size)) return false;
  return message.frame_us == 58319u && message.servo[0].zero_us == 8254u && message.servo[0].ns_per_deg == 48757u && message.servo[0].reversed == 92u && message.servo[0].min_cdeg == -1308 && message.servo[0].max_cdeg == -26340 && message.servo[1].zero_us == 54667u && message.servo[1].ns_per_deg == 29634u && message.servo[1].reversed == 17u && message.servo[1].min_cdeg == -20431 && message.servo[1].max_cdeg == 20073 && message.servo[2].zero_us == 35544u && message.servo[2].ns_per_deg == 10511u && message.servo[2].reversed == 199u && message.servo[2].min_cdeg == 25982 && message.servo[2].max_cdeg == 949;
}

static const uint8_t kPayloadSettingsWriteRequest[] = {0xCF, 0xE3, 0x3E, 0x20, 0x75, 0xBE, 0x5C, 0xE4, 0xFA, 0x1C, 0x99, 0x8B, 0xD5, 0xC2, 0x73, 0x11, 0x31, 0xB0, 0x69, 0x4E, 0xD8, 0x8A, 0x0F, 0x29, 0xC7, 0x7E, 0x65, 0xB5, 0x03};
static const uint8_t kFrameSettingsWriteRequest[] = {0x22, 0x15, 0x1E, 0xCF, 0xE3, 0x3E, 0x20, 0x75, 0xBE, 0x5C, 0xE4, 0xFA, 0x1C, 0x99, 0x8B, 0xD5, 0xC2, 0x73, 0x11, 0x31, 0xB0, 0x69, 0x4E, 0xD8, 0x8A, 0x0F, 0x29, 0xC7, 0x7E, 0x65, 0xB5, 0x03, 0x97, 0xC9, 0x00};

inline size_t build_SettingsWriteReply(uint8_t* payload) {
  protocol::SettingsWriteReply message;
  message.stored = 161u;
  message.written = 64u;
  message.encode(payload);
  return protocol::SettingsWriteReply::kSize;
}

inline bool matches_SettingsWriteReply(const uint8_t* payload, size_t size) {
  protocol::SettingsWriteReply message;
  if (!message.decode(payload, size)) return false;
  return message.stored == 161u && message.written == 64u;
}

static const uint8_t kPayloadSettingsWriteReply[] = {0xA1, 0x40};
static const uint8_t kFrameSettingsWriteReply[] = {0x07, 0x95, 0x1F, 0xA1, 0x40, 0xC3, 0xF7, 0x00};

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
static const uint8_t kFrameSettingsReadRequest[] = {0x05, 0x16, 0x20, 0xB8, 0x90, 0x00};

inline size_t build_SettingsReadReply(uint8_t* payload) {
  protocol::SettingsReadReply message;
  message.origin = protocol::Origin::kUploaded;
  message.generation = 2090061640u;
  message.frame_us = 6859u;
  message.servo[0].zero_us = 22330u;
  message.servo[0].ns_per_deg = 62833u;
  message.servo[0].reversed = 147u;
  message.servo[0].min_cdeg = 12768;
  message.servo[0].max_cdeg = -12264;
  message.servo[1].zero_us = 3207u;
  message.servo[1].ns_per_deg = 43710u;
  message.servo[1].reversed = 72u;
  message.servo[1].min_cdeg = -6355;
  message.servo[1].max_cdeg = -31388;
  message.servo[2].zero_us = 49619u;
  message.servo[2].ns_per_deg = 24587u;
  message.servo[2].reversed = 254u;
  message.servo[2].min_cdeg = -25478;
  message.servo[2].max_cdeg = 15025;
  message.encode(payload);
  return protocol::SettingsReadReply::kSize;
}

inline bool matches_SettingsReadReply(const uint8_t* payload, size_t size) {
  protocol::SettingsReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.origin == protocol::Origin::kUploaded && message.generation == 2090061640u && message.frame_us == 6859u && message.servo[0].zero_us == 22330u && message.servo[0].ns_per_deg == 62833u && message.servo[0].reversed == 147u && message.servo[0].min_cdeg == 12768 && message.servo[0].max_cdeg == -12264 && message.servo[1].zero_us == 3207u && message.servo[1].ns_per_deg == 43710u && message.servo[1].reversed == 72u && message.servo[1].min_cdeg == -6355 && message.servo[1].max_cdeg == -31388 && message.servo[2].zero_us == 49619u && message.servo[2].ns_per_deg == 24587u && message.servo[2].reversed == 254u && message.servo[2].min_cdeg == -25478 && message.servo[2].max_cdeg == 15025;
}

static const uint8_t kPayloadSettingsReadReply[] = {0x01, 0x48, 0xCF, 0x93, 0x7C, 0xCB, 0x1A, 0x3A, 0x57, 0x71, 0xF5, 0x93, 0xE0, 0x31, 0x18, 0xD0, 0x87, 0x0C, 0xBE, 0xAA, 0x48, 0x2D, 0xE7, 0x64, 0x85, 0xD3, 0xC1, 0x0B, 0x60, 0xFE, 0x7A, 0x9C, 0xB1, 0x3A};
static const uint8_t kFrameSettingsReadReply[] = {0x27, 0x96, 0x21, 0x01, 0x48, 0xCF, 0x93, 0x7C, 0xCB, 0x1A, 0x3A, 0x57, 0x71, 0xF5, 0x93, 0xE0, 0x31, 0x18, 0xD0, 0x87, 0x0C, 0xBE, 0xAA, 0x48, 0x2D, 0xE7, 0x64, 0x85, 0xD3, 0xC1, 0x0B, 0x60, 0xFE, 0x7A, 0x9C, 0xB1, 0x3A, 0x85, 0x1D, 0x00};

inline size_t build_JointReportRequest(uint8_t* payload) {
  protocol::JointReportRequest message;
  message.angle_cdeg[0] = -10007;
  message.angle_cdeg[1] = 30496;
  message.angle_cdeg[2] = 5464;
  message.encode(payload);
  return protocol::JointReportRequest::kSize;
}

inline bool matches_JointReportRequest(const uint8_t* payload, size_t size) {
  protocol::JointReportRequest message;
  if (!message.decode(payload, size)) return false;
  return message.angle_cdeg[0] == -10007 && message.angle_cdeg[1] == 30496 && message.angle_cdeg[2] == 5464;
}

static const uint8_t kPayloadJointReportRequest[] = {0xE9, 0xD8, 0x20, 0x77, 0x58, 0x15};
static const uint8_t kFrameJointReportRequest[] = {0x0B, 0x22, 0x22, 0xE9, 0xD8, 0x20, 0x77, 0x58, 0x15, 0xA4, 0x92, 0x00};

inline size_t build_JointReportReply(uint8_t* payload) {
  protocol::JointReportReply message;
  message.at_start_pose = 179u;
  message.encode(payload);
  return protocol::JointReportReply::kSize;
}

inline bool matches_JointReportReply(const uint8_t* payload, size_t size) {
  protocol::JointReportReply message;
  if (!message.decode(payload, size)) return false;
  return message.at_start_pose == 179u;
}

static const uint8_t kPayloadJointReportReply[] = {0xB3};
static const uint8_t kFrameJointReportReply[] = {0x06, 0xA2, 0x23, 0xB3, 0x6D, 0xDB, 0x00};

inline size_t build_JogRequest(uint8_t* payload) {
  protocol::JogRequest message;
  message.joint = 81u;
  message.from_cdeg = -4098;
  message.to_cdeg = -29130;
  message.confirm = 745383384u;
  message.encode(payload);
  return protocol::JogRequest::kSize;
}

inline bool matches_JogRequest(const uint8_t* payload, size_t size) {
  protocol::JogRequest message;
  if (!message.decode(payload, size)) return false;
  return message.joint == 81u && message.from_cdeg == -4098 && message.to_cdeg == -29130 && message.confirm == 745383384u;
}

static const uint8_t kPayloadJogRequest[] = {0x51, 0xFE, 0xEF, 0x36, 0x8E, 0xD8, 0xA5, 0x6D, 0x2C};
static const uint8_t kFrameJogRequest[] = {0x0E, 0x23, 0x24, 0x51, 0xFE, 0xEF, 0x36, 0x8E, 0xD8, 0xA5, 0x6D, 0x2C, 0x04, 0x98, 0x00};

inline size_t build_JogReply(uint8_t* payload) {
  protocol::JogReply message;
  message.angle_cdeg = -13659;
  message.arrived = 104u;
  message.encode(payload);
  return protocol::JogReply::kSize;
}

inline bool matches_JogReply(const uint8_t* payload, size_t size) {
  protocol::JogReply message;
  if (!message.decode(payload, size)) return false;
  return message.angle_cdeg == -13659 && message.arrived == 104u;
}

static const uint8_t kPayloadJogReply[] = {0xA5, 0xCA, 0x68};
static const uint8_t kFrameJogReply[] = {0x08, 0xA3, 0x25, 0xA5, 0xCA, 0x68, 0xEC, 0x1C, 0x00};

static const Vector kVectors[] = {
    {"HelloRequest", protocol::HelloRequest::kType, 0, build_HelloRequest, matches_HelloRequest, kPayloadHelloRequest, 0, kFrameHelloRequest, 6},
    {"HelloReply", protocol::HelloReply::kType, 1, build_HelloReply, matches_HelloReply, kPayloadHelloReply, 24, kFrameHelloReply, 30},
    {"SequencerStatusRequest", protocol::SequencerStatusRequest::kType, 2, build_SequencerStatusRequest, matches_SequencerStatusRequest, kPayloadSequencerStatusRequest, 0, kFrameSequencerStatusRequest, 6},
    {"SequencerStatusReply", protocol::SequencerStatusReply::kType, 3, build_SequencerStatusReply, matches_SequencerStatusReply, kPayloadSequencerStatusReply, 30, kFrameSequencerStatusReply, 36},
    {"RunReportRequest", protocol::RunReportRequest::kType, 4, build_RunReportRequest, matches_RunReportRequest, kPayloadRunReportRequest, 0, kFrameRunReportRequest, 6},
    {"RunReportReply", protocol::RunReportReply::kType, 5, build_RunReportReply, matches_RunReportReply, kPayloadRunReportReply, 74, kFrameRunReportReply, 80},
    {"LoggerStatusRequest", protocol::LoggerStatusRequest::kType, 6, build_LoggerStatusRequest, matches_LoggerStatusRequest, kPayloadLoggerStatusRequest, 0, kFrameLoggerStatusRequest, 6},
    {"LoggerStatusReply", protocol::LoggerStatusReply::kType, 7, build_LoggerStatusReply, matches_LoggerStatusReply, kPayloadLoggerStatusReply, 34, kFrameLoggerStatusReply, 40},
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
    {"RecordStartRequest", protocol::RecordStartRequest::kType, 22, build_RecordStartRequest, matches_RecordStartRequest, kPayloadRecordStartRequest, 4, kFrameRecordStartRequest, 10},
    {"RecordStartReply", protocol::RecordStartReply::kType, 23, build_RecordStartReply, matches_RecordStartReply, kPayloadRecordStartReply, 5, kFrameRecordStartReply, 11},
    {"RecordStopRequest", protocol::RecordStopRequest::kType, 24, build_RecordStopRequest, matches_RecordStopRequest, kPayloadRecordStopRequest, 0, kFrameRecordStopRequest, 6},
    {"RecordStopReply", protocol::RecordStopReply::kType, 25, build_RecordStopReply, matches_RecordStopReply, kPayloadRecordStopReply, 13, kFrameRecordStopReply, 19},
    {"LiveRequest", protocol::LiveRequest::kType, 26, build_LiveRequest, matches_LiveRequest, kPayloadLiveRequest, 1, kFrameLiveRequest, 7},
    {"LiveReply", protocol::LiveReply::kType, 27, build_LiveReply, matches_LiveReply, kPayloadLiveReply, 15, kFrameLiveReply, 21},
    {"LiveSampleStream", protocol::LiveSampleStream::kType, 28, build_LiveSampleStream, matches_LiveSampleStream, kPayloadLiveSampleStream, 86, kFrameLiveSampleStream, 92},
    {"ErrorReply", protocol::ErrorReply::kType, 29, build_ErrorReply, matches_ErrorReply, kPayloadErrorReply, 6, kFrameErrorReply, 12},
    {"SettingsWriteRequest", protocol::SettingsWriteRequest::kType, 30, build_SettingsWriteRequest, matches_SettingsWriteRequest, kPayloadSettingsWriteRequest, 29, kFrameSettingsWriteRequest, 35},
    {"SettingsWriteReply", protocol::SettingsWriteReply::kType, 31, build_SettingsWriteReply, matches_SettingsWriteReply, kPayloadSettingsWriteReply, 2, kFrameSettingsWriteReply, 8},
    {"SettingsReadRequest", protocol::SettingsReadRequest::kType, 32, build_SettingsReadRequest, matches_SettingsReadRequest, kPayloadSettingsReadRequest, 0, kFrameSettingsReadRequest, 6},
    {"SettingsReadReply", protocol::SettingsReadReply::kType, 33, build_SettingsReadReply, matches_SettingsReadReply, kPayloadSettingsReadReply, 34, kFrameSettingsReadReply, 40},
    {"JointReportRequest", protocol::JointReportRequest::kType, 34, build_JointReportRequest, matches_JointReportRequest, kPayloadJointReportRequest, 6, kFrameJointReportRequest, 12},
    {"JointReportReply", protocol::JointReportReply::kType, 35, build_JointReportReply, matches_JointReportReply, kPayloadJointReportReply, 1, kFrameJointReportReply, 7},
    {"JogRequest", protocol::JogRequest::kType, 36, build_JogRequest, matches_JogRequest, kPayloadJogRequest, 9, kFrameJogRequest, 15},
    {"JogReply", protocol::JogReply::kType, 37, build_JogReply, matches_JogReply, kPayloadJogReply, 3, kFrameJogReply, 9},
};

}  // namespace golden
}  // namespace tfsat

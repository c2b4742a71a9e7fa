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
  message.state = protocol::SequencerState::kRunning;
  message.fault = protocol::ErrorCode::kCardWriteFailed;
  message.last_refusal = protocol::ErrorCode::kSensorMissing;
  message.switches_open = 116u;
  message.arm_token = 4805u;
  message.reset_cause = protocol::ResetCause::kBrownOut;
  message.strokes_started = 79u;
  message.knocks = 60780u;
  message.joint_angle_cdeg[0] = -29789;
  message.joint_angle_cdeg[1] = 10715;
  message.joint_angle_cdeg[2] = -14318;
  message.uptime_ms = 1716123216u;
  message.encode(payload);
  return protocol::SequencerStatusReply::kSize;
}

inline bool matches_SequencerStatusReply(const uint8_t* payload, size_t size) {
  protocol::SequencerStatusReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::SequencerState::kRunning && message.fault == protocol::ErrorCode::kCardWriteFailed && message.last_refusal == protocol::ErrorCode::kSensorMissing && message.switches_open == 116u && message.arm_token == 4805u && message.reset_cause == protocol::ResetCause::kBrownOut && message.strokes_started == 79u && message.knocks == 60780u && message.joint_angle_cdeg[0] == -29789 && message.joint_angle_cdeg[1] == 10715 && message.joint_angle_cdeg[2] == -14318 && message.uptime_ms == 1716123216u;
}

static const uint8_t kPayloadSequencerStatusReply[] = {0x02, 0x2A, 0x2B, 0x74, 0xC5, 0x12, 0x02, 0x4F, 0x6C, 0xED, 0xA3, 0x8B, 0xDB, 0x29, 0x12, 0xC8, 0x50, 0xF6, 0x49, 0x66};
static const uint8_t kFrameSequencerStatusReply[] = {0x19, 0x82, 0x03, 0x02, 0x2A, 0x2B, 0x74, 0xC5, 0x12, 0x02, 0x4F, 0x6C, 0xED, 0xA3, 0x8B, 0xDB, 0x29, 0x12, 0xC8, 0x50, 0xF6, 0x49, 0x66, 0x9C, 0xDC, 0x00};

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
static const uint8_t kFrameLoggerStatusRequest[] = {0x05, 0x03, 0x04, 0xD8, 0x08, 0x00};

inline size_t build_LoggerStatusReply(uint8_t* payload) {
  protocol::LoggerStatusReply message;
  message.state = protocol::LoggerState::kFailed;
  message.error = protocol::ErrorCode::kJointUnknown;
  message.imu_present = 64u;
  message.switches_open = 223u;
  message.session = 2103400176u;
  message.samples = 462868649u;
  message.samples_dropped = 3117304419u;
  message.blocks_written = 1476772892u;
  message.ring_blocks = 63037u;
  message.ring_peak_blocks = 38004u;
  message.rate_hz = 12972u;
  message.who_am_i[0] = 208u;
  message.who_am_i[1] = 111u;
  message.who_am_i[2] = 13u;
  message.who_am_i[3] = 171u;
  message.uptime_ms = 1237422568u;
  message.encode(payload);
  return protocol::LoggerStatusReply::kSize;
}

inline bool matches_LoggerStatusReply(const uint8_t* payload, size_t size) {
  protocol::LoggerStatusReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kFailed && message.error == protocol::ErrorCode::kJointUnknown && message.imu_present == 64u && message.switches_open == 223u && message.session == 2103400176u && message.samples == 462868649u && message.samples_dropped == 3117304419u && message.blocks_written == 1476772892u && message.ring_blocks == 63037u && message.ring_peak_blocks == 38004u && message.rate_hz == 12972u && message.who_am_i[0] == 208u && message.who_am_i[1] == 111u && message.who_am_i[2] == 13u && message.who_am_i[3] == 171u && message.uptime_ms == 1237422568u;
}

static const uint8_t kPayloadLoggerStatusReply[] = {0x04, 0x08, 0x40, 0xDF, 0xF0, 0x56, 0x5F, 0x7D, 0xA9, 0xD0, 0x96, 0x1B, 0x63, 0x4A, 0xCE, 0xB9, 0x1C, 0xC4, 0x05, 0x58, 0x3D, 0xF6, 0x74, 0x94, 0xAC, 0x32, 0xD0, 0x6F, 0x0D, 0xAB, 0xE8, 0x91, 0xC1, 0x49};
static const uint8_t kFrameLoggerStatusReply[] = {0x27, 0x83, 0x05, 0x04, 0x08, 0x40, 0xDF, 0xF0, 0x56, 0x5F, 0x7D, 0xA9, 0xD0, 0x96, 0x1B, 0x63, 0x4A, 0xCE, 0xB9, 0x1C, 0xC4, 0x05, 0x58, 0x3D, 0xF6, 0x74, 0x94, 0xAC, 0x32, 0xD0, 0x6F, 0x0D, 0xAB, 0xE8, 0x91, 0xC1, 0x49, 0xC4, 0x5F, 0x00};

inline size_t build_ManeuverBeginRequest(uint8_t* payload) {
  protocol::ManeuverBeginRequest message;
  message.stroke_count = 231u;
  message.speed_cdeg_s = 34352u;
  message.encode(payload);
  return protocol::ManeuverBeginRequest::kSize;
}

inline bool matches_ManeuverBeginRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverBeginRequest message;
  if (!message.decode(payload, size)) return false;
  return message.stroke_count == 231u && message.speed_cdeg_s == 34352u;
}

static const uint8_t kPayloadManeuverBeginRequest[] = {0xE7, 0x30, 0x86};
static const uint8_t kFrameManeuverBeginRequest[] = {0x08, 0x10, 0x06, 0xE7, 0x30, 0x86, 0xB5, 0xE3, 0x00};

inline size_t build_ManeuverBeginReply(uint8_t* payload) {
  protocol::ManeuverBeginReply message;
  message.stroke_count = 36u;
  message.encode(payload);
  return protocol::ManeuverBeginReply::kSize;
}

inline bool matches_ManeuverBeginReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverBeginReply message;
  if (!message.decode(payload, size)) return false;
  return message.stroke_count == 36u;
}

static const uint8_t kPayloadManeuverBeginReply[] = {0x24};
static const uint8_t kFrameManeuverBeginReply[] = {0x06, 0x90, 0x07, 0x24, 0xD4, 0x49, 0x00};

inline size_t build_ManeuverStrokeRequest(uint8_t* payload) {
  protocol::ManeuverStrokeRequest message;
  message.index = 194u;
  message.joint = 96u;
  message.angle_cdeg = -242;
  message.start_us = 2638603771u;
  message.encode(payload);
  return protocol::ManeuverStrokeRequest::kSize;
}

inline bool matches_ManeuverStrokeRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverStrokeRequest message;
  if (!message.decode(payload, size)) return false;
  return message.index == 194u && message.joint == 96u && message.angle_cdeg == -242 && message.start_us == 2638603771u;
}

static const uint8_t kPayloadManeuverStrokeRequest[] = {0xC2, 0x60, 0x0E, 0xFF, 0xFB, 0xE5, 0x45, 0x9D};
static const uint8_t kFrameManeuverStrokeRequest[] = {0x0D, 0x11, 0x08, 0xC2, 0x60, 0x0E, 0xFF, 0xFB, 0xE5, 0x45, 0x9D, 0x4A, 0xB4, 0x00};

inline size_t build_ManeuverStrokeReply(uint8_t* payload) {
  protocol::ManeuverStrokeReply message;
  message.index = 59u;
  message.encode(payload);
  return protocol::ManeuverStrokeReply::kSize;
}

inline bool matches_ManeuverStrokeReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverStrokeReply message;
  if (!message.decode(payload, size)) return false;
  return message.index == 59u;
}

static const uint8_t kPayloadManeuverStrokeReply[] = {0x3B};
static const uint8_t kFrameManeuverStrokeReply[] = {0x06, 0x91, 0x09, 0x3B, 0x35, 0xBE, 0x00};

inline size_t build_ManeuverCommitRequest(uint8_t* payload) {
  protocol::ManeuverCommitRequest message;
  message.crc = 55732u;
  message.encode(payload);
  return protocol::ManeuverCommitRequest::kSize;
}

inline bool matches_ManeuverCommitRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverCommitRequest message;
  if (!message.decode(payload, size)) return false;
  return message.crc == 55732u;
}

static const uint8_t kPayloadManeuverCommitRequest[] = {0xB4, 0xD9};
static const uint8_t kFrameManeuverCommitRequest[] = {0x07, 0x12, 0x0A, 0xB4, 0xD9, 0x53, 0x3D, 0x00};

inline size_t build_ManeuverCommitReply(uint8_t* payload) {
  protocol::ManeuverCommitReply message;
  message.stored = 119u;
  message.written = 22u;
  message.encode(payload);
  return protocol::ManeuverCommitReply::kSize;
}

inline bool matches_ManeuverCommitReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverCommitReply message;
  if (!message.decode(payload, size)) return false;
  return message.stored == 119u && message.written == 22u;
}

static const uint8_t kPayloadManeuverCommitReply[] = {0x77, 0x16};
static const uint8_t kFrameManeuverCommitReply[] = {0x07, 0x92, 0x0B, 0x77, 0x16, 0xFF, 0xBC, 0x00};

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
static const uint8_t kFrameManeuverInfoRequest[] = {0x05, 0x13, 0x0C, 0xA3, 0x8A, 0x00};

inline size_t build_ManeuverInfoReply(uint8_t* payload) {
  protocol::ManeuverInfoReply message;
  message.origin = protocol::ManeuverOrigin::kUploaded;
  message.stroke_count = 82u;
  message.speed_cdeg_s = 61642u;
  message.crc = 36609u;
  message.end_us = 758721920u;
  message.generation = 3413157690u;
  message.encode(payload);
  return protocol::ManeuverInfoReply::kSize;
}

inline bool matches_ManeuverInfoReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverInfoReply message;
  if (!message.decode(payload, size)) return false;
  return message.origin == protocol::ManeuverOrigin::kUploaded && message.stroke_count == 82u && message.speed_cdeg_s == 61642u && message.crc == 36609u && message.end_us == 758721920u && message.generation == 3413157690u;
}

static const uint8_t kPayloadManeuverInfoReply[] = {0x01, 0x52, 0xCA, 0xF0, 0x01, 0x8F, 0x80, 0x2D, 0x39, 0x2D, 0x3A, 0xA7, 0x70, 0xCB};
static const uint8_t kFrameManeuverInfoReply[] = {0x13, 0x93, 0x0D, 0x01, 0x52, 0xCA, 0xF0, 0x01, 0x8F, 0x80, 0x2D, 0x39, 0x2D, 0x3A, 0xA7, 0x70, 0xCB, 0x21, 0x3D, 0x00};

inline size_t build_ManeuverReadRequest(uint8_t* payload) {
  protocol::ManeuverReadRequest message;
  message.index = 105u;
  message.encode(payload);
  return protocol::ManeuverReadRequest::kSize;
}

inline bool matches_ManeuverReadRequest(const uint8_t* payload, size_t size) {
  protocol::ManeuverReadRequest message;
  if (!message.decode(payload, size)) return false;
  return message.index == 105u;
}

static const uint8_t kPayloadManeuverReadRequest[] = {0x69};
static const uint8_t kFrameManeuverReadRequest[] = {0x06, 0x14, 0x0E, 0x69, 0xBF, 0x8D, 0x00};

inline size_t build_ManeuverReadReply(uint8_t* payload) {
  protocol::ManeuverReadReply message;
  message.index = 7u;
  message.joint = 166u;
  message.angle_cdeg = 17486;
  message.start_us = 3800434649u;
  message.encode(payload);
  return protocol::ManeuverReadReply::kSize;
}

inline bool matches_ManeuverReadReply(const uint8_t* payload, size_t size) {
  protocol::ManeuverReadReply message;
  if (!message.decode(payload, size)) return false;
  return message.index == 7u && message.joint == 166u && message.angle_cdeg == 17486 && message.start_us == 3800434649u;
}

static const uint8_t kPayloadManeuverReadReply[] = {0x07, 0xA6, 0x4E, 0x44, 0xD9, 0x07, 0x86, 0xE2};
static const uint8_t kFrameManeuverReadReply[] = {0x0D, 0x94, 0x0F, 0x07, 0xA6, 0x4E, 0x44, 0xD9, 0x07, 0x86, 0xE2, 0xA3, 0xC7, 0x00};

inline size_t build_ArmRequest(uint8_t* payload) {
  protocol::ArmRequest message;
  message.arm_token = 32957u;
  message.encode(payload);
  return protocol::ArmRequest::kSize;
}

inline bool matches_ArmRequest(const uint8_t* payload, size_t size) {
  protocol::ArmRequest message;
  if (!message.decode(payload, size)) return false;
  return message.arm_token == 32957u;
}

static const uint8_t kPayloadArmRequest[] = {0xBD, 0x80};
static const uint8_t kFrameArmRequest[] = {0x07, 0x20, 0x10, 0xBD, 0x80, 0x34, 0x09, 0x00};

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
static const uint8_t kFrameArmReply[] = {0x06, 0xA0, 0x11, 0x03, 0x21, 0x71, 0x00};

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
static const uint8_t kFrameDisarmRequest[] = {0x05, 0x21, 0x12, 0xAB, 0x1A, 0x00};

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
static const uint8_t kFrameDisarmReply[] = {0x06, 0xA1, 0x13, 0x04, 0x94, 0x50, 0x00};

inline size_t build_RecordStartRequest(uint8_t* payload) {
  protocol::RecordStartRequest message;
  message.number = 1533275839u;
  message.encode(payload);
  return protocol::RecordStartRequest::kSize;
}

inline bool matches_RecordStartRequest(const uint8_t* payload, size_t size) {
  protocol::RecordStartRequest message;
  if (!message.decode(payload, size)) return false;
  return message.number == 1533275839u;
}

static const uint8_t kPayloadRecordStartRequest[] = {0xBF, 0xEE, 0x63, 0x5B};
static const uint8_t kFrameRecordStartRequest[] = {0x09, 0x40, 0x14, 0xBF, 0xEE, 0x63, 0x5B, 0xB4, 0xC2, 0x00};

inline size_t build_RecordStartReply(uint8_t* payload) {
  protocol::RecordStartReply message;
  message.state = protocol::LoggerState::kRecording;
  message.session = 2547180082u;
  message.encode(payload);
  return protocol::RecordStartReply::kSize;
}

inline bool matches_RecordStartReply(const uint8_t* payload, size_t size) {
  protocol::RecordStartReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kRecording && message.session == 2547180082u;
}

static const uint8_t kPayloadRecordStartReply[] = {0x01, 0x32, 0xE2, 0xD2, 0x97};
static const uint8_t kFrameRecordStartReply[] = {0x0A, 0xC0, 0x15, 0x01, 0x32, 0xE2, 0xD2, 0x97, 0xC4, 0xFB, 0x00};

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
static const uint8_t kFrameRecordStopRequest[] = {0x05, 0x41, 0x16, 0x05, 0x51, 0x00};

inline size_t build_RecordStopReply(uint8_t* payload) {
  protocol::RecordStopReply message;
  message.state = protocol::LoggerState::kStopped;
  message.session = 3561084325u;
  message.samples = 1920552799u;
  message.samples_dropped = 280021272u;
  message.encode(payload);
  return protocol::RecordStopReply::kSize;
}

inline bool matches_RecordStopReply(const uint8_t* payload, size_t size) {
  protocol::RecordStopReply message;
  if (!message.decode(payload, size)) return false;
  return message.state == protocol::LoggerState::kStopped && message.session == 3561084325u && message.samples == 1920552799u && message.samples_dropped == 280021272u;
}

static const uint8_t kPayloadRecordStopReply[] = {0x03, 0xA5, 0xD5, 0x41, 0xD4, 0x5F, 0x4F, 0x79, 0x72, 0x18, 0xC9, 0xB0, 0x10};
static const uint8_t kFrameRecordStopReply[] = {0x12, 0xC1, 0x17, 0x03, 0xA5, 0xD5, 0x41, 0xD4, 0x5F, 0x4F, 0x79, 0x72, 0x18, 0xC9, 0xB0, 0x10, 0x5F, 0x35, 0x00};

inline size_t build_LiveRequest(uint8_t* payload) {
  protocol::LiveRequest message;
  message.enabled = 174u;
  message.encode(payload);
  return protocol::LiveRequest::kSize;
}

inline bool matches_LiveRequest(const uint8_t* payload, size_t size) {
  protocol::LiveRequest message;
  if (!message.decode(payload, size)) return false;
  return message.enabled == 174u;
}

static const uint8_t kPayloadLiveRequest[] = {0xAE};
static const uint8_t kFrameLiveRequest[] = {0x06, 0x42, 0x18, 0xAE, 0xAF, 0x61, 0x00};

inline size_t build_LiveReply(uint8_t* payload) {
  protocol::LiveReply message;
  message.enabled = 77u;
  message.rate_hz = 60247u;
  message.gyro_lsb_per_deg_s = 14.5f;
  message.accel_lsb_per_g = 207.8125f;
  message.angle_counts_per_turn = 3321734001u;
  message.encode(payload);
  return protocol::LiveReply::kSize;
}

inline bool matches_LiveReply(const uint8_t* payload, size_t size) {
  protocol::LiveReply message;
  if (!message.decode(payload, size)) return false;
  return message.enabled == 77u && message.rate_hz == 60247u && message.gyro_lsb_per_deg_s == 14.5f && message.accel_lsb_per_g == 207.8125f && message.angle_counts_per_turn == 3321734001u;
}

static const uint8_t kPayloadLiveReply[] = {0x4D, 0x57, 0xEB, 0x00, 0x00, 0x68, 0x41, 0x00, 0xD0, 0x4F, 0x43, 0x71, 0xA3, 0xFD, 0xC5};
static const uint8_t kFrameLiveReply[] = {0x06, 0xC2, 0x19, 0x4D, 0x57, 0xEB, 0x01, 0x03, 0x68, 0x41, 0x0A, 0xD0, 0x4F, 0x43, 0x71, 0xA3, 0xFD, 0xC5, 0x3C, 0xCF, 0x00};

inline size_t build_LiveSampleStream(uint8_t* payload) {
  protocol::LiveSampleStream message;
  message.index = 1681202475u;
  message.time_us = 174680394955813180ull;
  message.sample.time_offset_us = 1054575191u;
  message.sample.flags = 56595u;
  message.sample.imu[0].accel[0] = 6529;
  message.sample.imu[0].accel[1] = -18503;
  message.sample.imu[0].accel[2] = 22000;
  message.sample.imu[0].temperature = -3032;
  message.sample.imu[0].gyro[0] = -28065;
  message.sample.imu[0].gyro[1] = 12439;
  message.sample.imu[0].gyro[2] = -12594;
  message.sample.imu[1].accel[0] = 2877;
  message.sample.imu[1].accel[1] = -22155;
  message.sample.imu[1].accel[2] = 18348;
  message.sample.imu[1].temperature = -6684;
  message.sample.imu[1].gyro[0] = -31717;
  message.sample.imu[1].gyro[1] = 8787;
  message.sample.imu[1].gyro[2] = -16246;
  message.sample.imu[2].accel[0] = -775;
  message.sample.imu[2].accel[1] = -25807;
  message.sample.imu[2].accel[2] = 14696;
  message.sample.imu[2].temperature = -10336;
  message.sample.imu[2].gyro[0] = 30167;
  message.sample.imu[2].gyro[1] = 5134;
  message.sample.imu[2].gyro[2] = -19898;
  message.sample.imu[3].accel[0] = -4427;
  message.sample.imu[3].accel[1] = -29460;
  message.sample.imu[3].accel[2] = 11044;
  message.sample.imu[3].temperature = -13989;
  message.sample.imu[3].gyro[0] = 26515;
  message.sample.imu[3].gyro[1] = 1482;
  message.sample.imu[3].gyro[2] = -23550;
  message.sample.angle[0] = 16953u;
  message.sample.angle[1] = 57457u;
  message.sample.angle[2] = 32424u;
  message.sample.angle[3] = 7392u;
  message.sample.angle[4] = 47895u;
  message.sample.angle[5] = 22863u;
  message.encode(payload);
  return protocol::LiveSampleStream::kSize;
}

inline bool matches_LiveSampleStream(const uint8_t* payload, size_t size) {
  protocol::LiveSampleStream message;
  if (!message.decode(payload, size)) return false;
  return message.index == 1681202475u && message.time_us == 174680394955813180ull && message.sample.time_offset_us == 1054575191u && message.sample.flags == 56595u && message.sample.imu[0].accel[0] == 6529 && message.sample.imu[0].accel[1] == -18503 && message.sample.imu[0].accel[2] == 22000 && message.sample.imu[0].temperature == -3032 && message.sample.imu[0].gyro[0] == -28065 && message.sample.imu[0].gyro[1] == 12439 && message.sample.imu[0].gyro[2] == -12594 && message.sample.imu[1].accel[0] == 2877 && message.sample.imu[1].accel[1] == -22155 && message.sample.imu[1].accel[2] == 18348 && message.sample.imu[1].temperature == -6684 && message.sample.imu[1].gyro[0] == -31717 && message.sample.imu[1].gyro[1] == 8787 && message.sample.imu[1].gyro[2] == -16246 && message.sample.imu[2].accel[0] == -775 && message.sample.imu[2].accel[1] == -25807 && message.sample.imu[2].accel[2] == 14696 && message.sample.imu[2].temperature == -10336 && message.sample.imu[2].gyro[0] == 30167 && message.sample.imu[2].gyro[1] == 5134 && message.sample.imu[2].gyro[2] == -19898 && message.sample.imu[3].accel[0] == -4427 && message.sample.imu[3].accel[1] == -29460 && message.sample.imu[3].accel[2] == 11044 && message.sample.imu[3].temperature == -13989 && message.sample.imu[3].gyro[0] == 26515 && message.sample.imu[3].gyro[1] == 1482 && message.sample.imu[3].gyro[2] == -23550 && message.sample.angle[0] == 16953u && message.sample.angle[1] == 57457u && message.sample.angle[2] == 32424u && message.sample.angle[3] == 7392u && message.sample.angle[4] == 47895u && message.sample.angle[5] == 22863u;
}

static const uint8_t kPayloadLiveSampleStream[] = {0x2B, 0x1D, 0x35, 0x64, 0x3C, 0xF1, 0x90, 0xCA, 0xE4, 0x96, 0x6C, 0x02, 0x57, 0x8A, 0xDB, 0x3E, 0x13, 0xDD, 0x81, 0x19, 0xB9, 0xB7, 0xF0, 0x55, 0x28, 0xF4, 0x5F, 0x92, 0x97, 0x30, 0xCE, 0xCE, 0x3D, 0x0B, 0x75, 0xA9, 0xAC, 0x47, 0xE4, 0xE5, 0x1B, 0x84, 0x53, 0x22, 0x8A, 0xC0, 0xF9, 0xFC, 0x31, 0x9B, 0x68, 0x39, 0xA0, 0xD7, 0xD7, 0x75, 0x0E, 0x14, 0x46, 0xB2, 0xB5, 0xEE, 0xEC, 0x8C, 0x24, 0x2B, 0x5B, 0xC9, 0x93, 0x67, 0xCA, 0x05, 0x02, 0xA4, 0x39, 0x42, 0x71, 0xE0, 0xA8, 0x7E, 0xE0, 0x1C, 0x17, 0xBB, 0x4F, 0x59};
static const uint8_t kFrameLiveSampleStream[] = {0x5B, 0x60, 0x1A, 0x2B, 0x1D, 0x35, 0x64, 0x3C, 0xF1, 0x90, 0xCA, 0xE4, 0x96, 0x6C, 0x02, 0x57, 0x8A, 0xDB, 0x3E, 0x13, 0xDD, 0x81, 0x19, 0xB9, 0xB7, 0xF0, 0x55, 0x28, 0xF4, 0x5F, 0x92, 0x97, 0x30, 0xCE, 0xCE, 0x3D, 0x0B, 0x75, 0xA9, 0xAC, 0x47, 0xE4, 0xE5, 0x1B, 0x84, 0x53, 0x22, 0x8A, 0xC0, 0xF9, 0xFC, 0x31, 0x9B, 0x68, 0x39, 0xA0, 0xD7, 0xD7, 0x75, 0x0E, 0x14, 0x46, 0xB2, 0xB5, 0xEE, 0xEC, 0x8C, 0x24, 0x2B, 0x5B, 0xC9, 0x93, 0x67, 0xCA, 0x05, 0x02, 0xA4, 0x39, 0x42, 0x71, 0xE0, 0xA8, 0x7E, 0xE0, 0x1C, 0x17, 0xBB, 0x4F, 0x59, 0xD0, 0x3B, 0x00};

inline size_t build_ErrorReply(uint8_t* payload) {
  protocol::ErrorReply message;
  message.request = 247u;
  message.code = protocol::ErrorCode::kSensorMissing;
  message.detail = 871727814;
  message.encode(payload);
  return protocol::ErrorReply::kSize;
}

inline bool matches_ErrorReply(const uint8_t* payload, size_t size) {
  protocol::ErrorReply message;
  if (!message.decode(payload, size)) return false;
  return message.request == 247u && message.code == protocol::ErrorCode::kSensorMissing && message.detail == 871727814;
}

static const uint8_t kPayloadErrorReply[] = {0xF7, 0x2B, 0xC6, 0x82, 0xF5, 0x33};
static const uint8_t kFrameErrorReply[] = {0x0B, 0xFF, 0x1B, 0xF7, 0x2B, 0xC6, 0x82, 0xF5, 0x33, 0x90, 0x4F, 0x00};

static const Vector kVectors[] = {
    {"HelloRequest", protocol::HelloRequest::kType, 0, build_HelloRequest, matches_HelloRequest, kPayloadHelloRequest, 0, kFrameHelloRequest, 6},
    {"HelloReply", protocol::HelloReply::kType, 1, build_HelloReply, matches_HelloReply, kPayloadHelloReply, 24, kFrameHelloReply, 30},
    {"SequencerStatusRequest", protocol::SequencerStatusRequest::kType, 2, build_SequencerStatusRequest, matches_SequencerStatusRequest, kPayloadSequencerStatusRequest, 0, kFrameSequencerStatusRequest, 6},
    {"SequencerStatusReply", protocol::SequencerStatusReply::kType, 3, build_SequencerStatusReply, matches_SequencerStatusReply, kPayloadSequencerStatusReply, 20, kFrameSequencerStatusReply, 26},
    {"LoggerStatusRequest", protocol::LoggerStatusRequest::kType, 4, build_LoggerStatusRequest, matches_LoggerStatusRequest, kPayloadLoggerStatusRequest, 0, kFrameLoggerStatusRequest, 6},
    {"LoggerStatusReply", protocol::LoggerStatusReply::kType, 5, build_LoggerStatusReply, matches_LoggerStatusReply, kPayloadLoggerStatusReply, 34, kFrameLoggerStatusReply, 40},
    {"ManeuverBeginRequest", protocol::ManeuverBeginRequest::kType, 6, build_ManeuverBeginRequest, matches_ManeuverBeginRequest, kPayloadManeuverBeginRequest, 3, kFrameManeuverBeginRequest, 9},
    {"ManeuverBeginReply", protocol::ManeuverBeginReply::kType, 7, build_ManeuverBeginReply, matches_ManeuverBeginReply, kPayloadManeuverBeginReply, 1, kFrameManeuverBeginReply, 7},
    {"ManeuverStrokeRequest", protocol::ManeuverStrokeRequest::kType, 8, build_ManeuverStrokeRequest, matches_ManeuverStrokeRequest, kPayloadManeuverStrokeRequest, 8, kFrameManeuverStrokeRequest, 14},
    {"ManeuverStrokeReply", protocol::ManeuverStrokeReply::kType, 9, build_ManeuverStrokeReply, matches_ManeuverStrokeReply, kPayloadManeuverStrokeReply, 1, kFrameManeuverStrokeReply, 7},
    {"ManeuverCommitRequest", protocol::ManeuverCommitRequest::kType, 10, build_ManeuverCommitRequest, matches_ManeuverCommitRequest, kPayloadManeuverCommitRequest, 2, kFrameManeuverCommitRequest, 8},
    {"ManeuverCommitReply", protocol::ManeuverCommitReply::kType, 11, build_ManeuverCommitReply, matches_ManeuverCommitReply, kPayloadManeuverCommitReply, 2, kFrameManeuverCommitReply, 8},
    {"ManeuverInfoRequest", protocol::ManeuverInfoRequest::kType, 12, build_ManeuverInfoRequest, matches_ManeuverInfoRequest, kPayloadManeuverInfoRequest, 0, kFrameManeuverInfoRequest, 6},
    {"ManeuverInfoReply", protocol::ManeuverInfoReply::kType, 13, build_ManeuverInfoReply, matches_ManeuverInfoReply, kPayloadManeuverInfoReply, 14, kFrameManeuverInfoReply, 20},
    {"ManeuverReadRequest", protocol::ManeuverReadRequest::kType, 14, build_ManeuverReadRequest, matches_ManeuverReadRequest, kPayloadManeuverReadRequest, 1, kFrameManeuverReadRequest, 7},
    {"ManeuverReadReply", protocol::ManeuverReadReply::kType, 15, build_ManeuverReadReply, matches_ManeuverReadReply, kPayloadManeuverReadReply, 8, kFrameManeuverReadReply, 14},
    {"ArmRequest", protocol::ArmRequest::kType, 16, build_ArmRequest, matches_ArmRequest, kPayloadArmRequest, 2, kFrameArmRequest, 8},
    {"ArmReply", protocol::ArmReply::kType, 17, build_ArmReply, matches_ArmReply, kPayloadArmReply, 1, kFrameArmReply, 7},
    {"DisarmRequest", protocol::DisarmRequest::kType, 18, build_DisarmRequest, matches_DisarmRequest, kPayloadDisarmRequest, 0, kFrameDisarmRequest, 6},
    {"DisarmReply", protocol::DisarmReply::kType, 19, build_DisarmReply, matches_DisarmReply, kPayloadDisarmReply, 1, kFrameDisarmReply, 7},
    {"RecordStartRequest", protocol::RecordStartRequest::kType, 20, build_RecordStartRequest, matches_RecordStartRequest, kPayloadRecordStartRequest, 4, kFrameRecordStartRequest, 10},
    {"RecordStartReply", protocol::RecordStartReply::kType, 21, build_RecordStartReply, matches_RecordStartReply, kPayloadRecordStartReply, 5, kFrameRecordStartReply, 11},
    {"RecordStopRequest", protocol::RecordStopRequest::kType, 22, build_RecordStopRequest, matches_RecordStopRequest, kPayloadRecordStopRequest, 0, kFrameRecordStopRequest, 6},
    {"RecordStopReply", protocol::RecordStopReply::kType, 23, build_RecordStopReply, matches_RecordStopReply, kPayloadRecordStopReply, 13, kFrameRecordStopReply, 19},
    {"LiveRequest", protocol::LiveRequest::kType, 24, build_LiveRequest, matches_LiveRequest, kPayloadLiveRequest, 1, kFrameLiveRequest, 7},
    {"LiveReply", protocol::LiveReply::kType, 25, build_LiveReply, matches_LiveReply, kPayloadLiveReply, 15, kFrameLiveReply, 21},
    {"LiveSampleStream", protocol::LiveSampleStream::kType, 26, build_LiveSampleStream, matches_LiveSampleStream, kPayloadLiveSampleStream, 86, kFrameLiveSampleStream, 92},
    {"ErrorReply", protocol::ErrorReply::kType, 27, build_ErrorReply, matches_ErrorReply, kPayloadErrorReply, 6, kFrameErrorReply, 12},
};

}  // namespace golden
}  // namespace tfsat

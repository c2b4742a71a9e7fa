// Generated from protocol/tfsat.toml by tools/generate_protocol.py. Do not edit.
#ifndef TFSAT_PROTOCOL_MESSAGES_H
#define TFSAT_PROTOCOL_MESSAGES_H

#include <stddef.h>
#include <stdint.h>

#include "wire.h"

namespace tfsat {
namespace protocol {

constexpr uint8_t kProtocolHash[8] = {0x0C, 0x22, 0x5F, 0x03, 0x8F, 0xE3, 0x7B, 0xE9};
constexpr uint8_t kFirmwareVersion[3] = {0, 2, 0};
constexpr size_t kMaxPayloadBytes = 96;
constexpr uint8_t kReplyBit = 0x80;

// Joints that can stroke.
constexpr uint32_t kJointCount = 3;
// MPU-6050, one a body.
constexpr uint32_t kImuCount = 4;
// Absolute angle sensors, two a joint: index 2 (joint - 1) and the next.
constexpr uint32_t kAngleSensorCount = 6;
// Release switches.
constexpr uint32_t kSwitchCount = 2;
// Strokes that a maneuver can have.
constexpr uint32_t kMaxStrokes = 16;
// Least joint angle, 0.01 deg (paper, eq. optdef).
constexpr uint32_t kJointAngleMinCdeg = 0;
// Greatest joint angle, 0.01 deg (paper, eq. optdef).
constexpr uint32_t kJointAngleMaxCdeg = 9000;
// Least average joint speed that a maneuver may assume, 0.01 deg/s.
constexpr uint32_t kSpeedMinCdegS = 1000;
// Greatest average joint speed that a maneuver may assume, 0.01 deg/s.
constexpr uint32_t kSpeedMaxCdegS = 40000;
// Earliest stroke after the release: in 0.7 s the robot is clear of the releaser at 30 mm/s (paper, sec. seq).
constexpr uint32_t kPauseMinUs = 700000;
// Time of free fall (paper, tab. cosmotorre). A maneuver must end before.
constexpr uint32_t kFallUs = 2500000;
// Stroke times are rounded up to this grid by the host.
constexpr uint32_t kScheduleGridUs = 10000;
// No pulse is shorter.
constexpr uint32_t kServoPulseMinUs = 500;
// No pulse is longer.
constexpr uint32_t kServoPulseMaxUs = 2500;
// Factory setting: pulse width that holds a joint at 0 deg.
constexpr uint32_t kServoFactoryZeroUs = 1000;
// Factory setting: pulse width for each further degree.
constexpr uint32_t kServoFactoryNsPerDeg = 11111;
// Least slope of a servo that a setting may claim.
constexpr uint32_t kServoNsPerDegMin = 2000;
// Greatest slope of a servo that a setting may claim.
constexpr uint32_t kServoNsPerDegMax = 30000;
// Factory setting: from pulse to pulse.
constexpr uint32_t kServoFrameUs = 20000;
// Factory setting: joints that move at the same time.
constexpr uint32_t kMovingAtOnce = 1;
// Fastest frame that a digital servo may be given.
constexpr uint32_t kServoFrameMinUs = 5000;
// Slowest frame that holds a servo.
constexpr uint32_t kServoFrameMaxUs = 20000;
// A joint counts as at its start pose this near to it: gravity bends the hanging robot by some 6 deg (paper, sec. Result).
constexpr uint32_t kStartPoseToleranceCdeg = 1000;
// A joint-angle report older than this says nothing any more.
constexpr uint32_t kJointReportAgeMs = 30000;
// Speed of a jog: slow enough to watch, and to let go of.
constexpr uint32_t kJogSpeedCdegS = 1500;
// The flag that a jog must carry: 'JOG'.
constexpr uint32_t kJogConfirm = 4869959;
// A jogged joint that gets no further order goes limp after this: a host that froze must not let it go on.
constexpr uint32_t kJogIdleMs = 1000;
// The sequencer's stroke line stays high this long from each stroke's first pulse.
constexpr uint32_t kStrokeLineUs = 1000;
// In RUN_REPORT, in place of an onset: the stroke has not begun; when the run is over, it was missed.
constexpr uint32_t kStrokeNotBegunUs = 4294967295;
// In RUN_REPORT, in place of an onset: the stroke began, but a reset came before its time was noted.
constexpr uint32_t kStrokeTimeUnknownUs = 4294967294;
// Both switches open for this long confirm a release; the schedule counts from the first edge.
constexpr uint32_t kReleaseDebounceUs = 5000;
// Longest bounce of sound contacts when they open.
constexpr uint32_t kReleaseBounceUs = 10000;
// Longest bounce of worn contacts when they open; with both switches open for longer the robot has left.
constexpr uint32_t kReleaseChatterUs = 60000;
// Both switches closed for this long between two openings: no bounce of sound contacts, the robot may still have hung.
constexpr uint32_t kReleaseHungUs = 1000;
// Both switches closed again for this long: a false release, the robot still hangs.
constexpr uint32_t kReleaseSeatedUs = 200000;
// Factory setting: sampling rate (paper, sec. robot).
constexpr uint32_t kSampleRateHz = 280;
// Slowest sampling rate that a setting may ask for.
constexpr uint32_t kSampleRateMinHz = 10;
// Fastest sampling rate: the MPU-6050's accelerometer makes no more values (RM-MPU-6000A rev. 4.2, p. 11).
constexpr uint32_t kSampleRateMaxHz = 1000;
// Bits on the bus for one 14-byte burst: 17 bytes of 9 bits, 3 for start, restart and stop.
constexpr uint32_t kImuBurstBits = 156;
// An MPU-6050 has two addresses, so a bus carries two.
constexpr uint32_t kImusPerBus = 2;
// On the bus, for an IMU to show one of its settings.
constexpr uint32_t kImuProofBits = 39;
// That such a transfer may take beyond its bits.
constexpr uint32_t kImuProofSlackUs = 20;
// Of each sampling period, kept for a sensor that fails and for the processor.
constexpr uint32_t kSamplingMarginUs = 200;
// Factory setting: the paper's range.
constexpr uint32_t kGyroRangeFactoryDegS = 500;
// Factory setting: the widest, for the landing.
constexpr uint32_t kAccelRangeFactoryG = 16;
// Factory setting: 42 Hz, 4.8 ms.
constexpr uint32_t kDlpfFactory = 3;
// Factory setting: I2C fast mode.
constexpr uint32_t kBusFactoryKhz = 400;
// Factory setting: a recording goes on this long after the landing, then closes by itself.
constexpr uint32_t kAfterLandingFactoryS = 30;
// Least time that a recording goes on after the landing: longer than a fall, should a shock in it be taken for the landing.
constexpr uint32_t kAfterLandingMinS = 5;
// Most.
constexpr uint32_t kAfterLandingMaxS = 600;
// Factory setting: room that a recording takes on the card; 23 minutes at 280 Hz.
constexpr uint32_t kFileFactoryMib = 32;
// Least room.
constexpr uint32_t kFileMinMib = 1;
// Most.
constexpr uint32_t kFileMaxMib = 1024;
// Blocks that the logger's RAM holds: 5.3 s at 1 kHz, 19 s at 280 Hz.
constexpr uint32_t kRingBlocks = 896;
// A specific force of this much on one axis, after the release, is the landing. Strokes stay under 2 g.
constexpr uint32_t kLandingShockG = 6;
// Earliest landing after the release.
constexpr uint32_t kLandingEarliestUs = 300000;
// Latest landing after the release, whatever the sensors read.
constexpr uint32_t kLandingLatestUs = 5000000;
// This long after the landing, the blow is over, and what RAM holds of the fall is written a second time.
constexpr uint32_t kRewriteAfterLandingUs = 1000000;
// And not before this time after the release, should a shock in the fall be taken for the landing.
constexpr uint32_t kRewriteAfterReleaseUs = 4000000;
// The second copy begins this long before the release, or where RAM does.
constexpr uint32_t kRewriteBeforeReleaseUs = 1000000;
// An IMU whose output does not change by one bit for this long has stopped measuring: its noise alone is some counts.
constexpr uint32_t kFrozenUs = 100000;
// A block crosses the cable in parts of this size.
constexpr uint32_t kLogPartBytes = 64;
// Most blocks that one log_read sends.
constexpr uint32_t kLogReadBlocks = 128;
// A block on the card.
constexpr uint32_t kBlockBytes = 512;
// The bytes 'TFS1' that every block begins with.
constexpr uint32_t kBlockMagic = 827541076;
// Version of the block layout. 2 is read as well: it has no imu_offset_us and angle_offset_us.
constexpr uint32_t kBlockVersion = 3;
// Sample slots in a data block.
constexpr uint32_t kSamplesPerBlock = 6;
// Event slots in a data block.
constexpr uint32_t kEventsPerBlock = 2;
// The header block is written again each time this many blocks have passed.
constexpr uint32_t kHeaderRepeatBlocks = 256;
// A data block that has waited this long is written as far as it is filled.
constexpr uint32_t kPartialBlockMs = 100;
// The card is told to flush its own buffers at this interval.
constexpr uint32_t kCardSyncMs = 250;

// Where things stand in a block.
constexpr size_t kSamplesOffset = 32;
constexpr size_t kEventsOffset = 476;
constexpr size_t kBlockCrcOffset = 508;

// Parts that may be IMUs.
struct ImuPart {
  uint8_t who_am_i;
  float temperature_lsb_per_c;
  float temperature_offset_c;
  bool has_accel_filter;  // ACCEL_CONFIG_2
};
constexpr ImuPart kImuParts[] = {
    {0x68, 340.0f, 36.53f, false},  // MPU-6050
    {0x70, 333.87f, 21.0f, true},  // MPU-6500
    {0x71, 333.87f, 21.0f, true},  // MPU-9250
    {0x73, 333.87f, 21.0f, true},  // MPU-9255
    {0x98, 326.8f, 25.0f, true},  // ICM-20689
};

// LogHeader::schema.
constexpr char kLogSchema[] =
    "tfsat log, little endian, 512 B blocks: head 32, 6 Sample, 2 Event, CRC-32 at 508. Read at"
    " + imu_offset_us, angle_offset_us. Sample: time_offset_us u32, flags u16, imu ImuReading[4"
    "], angle u16[6] turn/angle_counts_per_turn. ImuReading: accel i16[3] g/accel_lsb_per_g, te"
    "mperature i16 C, gyro i16[3] deg/s/gyro_lsb_per_deg_s. Event: time_us u64, code u8, index "
    "u8, arg u16, value i32.";

// Kind of board that answers HELLO.
enum class Board : uint8_t {
  kSequencer = 1,  // Arduino Micro: flies the maneuver.
  kLogger = 2,  // Teensy 4.1: records the fall.
};

// The sequencer's state machine.
enum class SequencerState : uint8_t {
  kSafe = 0,  // Nothing moves. No servo pulses.
  kArmed = 1,  // Servos hold the start pose; the release starts the schedule.
  kRunning = 2,  // Released: strokes run on schedule. ARMED again after a false release.
  kDone = 3,  // All strokes were commanded; servos hold the end pose.
  kFault = 4,  // Something is wrong; nothing new is commanded until a person disarms. Servos that were driven are held where they were.
  kJogging = 5,  // One joint is moved slowly on a person's order; the others get no pulses.
};

// Where a maneuver or the settings on the board come from.
enum class Origin : uint8_t {
  kFactory = 0,  // Never uploaded: kept in the firmware (the maneuver is the paper's 59/70).
  kUploaded = 1,  // Uploaded by a host and stored in EEPROM.
};

// Why the board last started.
enum class ResetCause : uint8_t {
  kPowerOn = 0,  // Power was switched on.
  kExternal = 1,  // The reset pin or button, or an upload.
  kBrownOut = 2,  // The supply dipped.
  kWatchdog = 3,  // The main loop hung.
  kUnknown = 4,  // The bootloader hid the cause.
};

// The logger's state.
enum class LoggerState : uint8_t {
  kIdle = 0,  // Sampling, not recording.
  kRecording = 1,  // Samples go to the card.
  kStopping = 2,  // The ring is being emptied and the footer written.
  kStopped = 3,  // The last recording was closed cleanly.
  kFailed = 4,  // The card refused; see the error code. RAM keeps the newest seconds, after a landing the drop.
};

// What the logger knows of its card.
enum class CardState : uint8_t {
  kUnknown = 0,  // Not looked at yet, or its free room is being counted.
  kReady = 1,  // A recording would find room.
  kMissing = 2,  // No card, or one without contact.
  kUnreadable = 3,  // A card without a file system that the logger knows.
  kFull = 4,  // No room for a recording.
  kWriteProtected = 5,  // The card's own registers forbid writing.
  kFailing = 6,  // It refused a write, or has been busy for too long.
};

// Where in a drop the recording is, by the release switches and the accelerometers.
enum class DropPhase : uint8_t {
  kWaiting = 0,  // Not released.
  kFalling = 1,  // Released.
  kLanded = 2,  // Landed; the recording closes by itself after a while.
};

// Why a recording ended.
enum class StopReason : uint8_t {
  kHost = 1,  // A host asked for it.
  kLanding = 2,  // The time after the landing was over.
  kFileFull = 3,  // The file had no more room; before a release the recording goes on in the next.
  kCardGone = 4,  // The card took nothing, and more samples would have cost RAM the drop.
};

// What a block on the card holds.
enum class BlockKind : uint8_t {
  kHeader = 1,  // LogHeader: what was recorded, with which scales.
  kData = 2,  // Samples and events.
  kFooter = 3,  // LogFooter: the recording was closed cleanly.
};

// Events in the log.
enum class EventCode : uint8_t {
  kSwitchEdge = 1,  // A release switch changed: index = switch, arg = 1 opened, 0 closed, value = edges before it that came too fast to keep.
  kStroke = 2,  // The sequencer's stroke line rose: index = count since the recording began, from 0, value = edges before it that came too fast to keep.
  kSensorFault = 3,  // A sensor gives no readings any more, or for another reason than before: index = IMU, arg = error code; sensor_foreign: value = its WHO_AM_I; else value = microseconds before the event from which its readings are in doubt, 0: none. They repeat (sensor_frozen), or may be in other scales: a part that wakes up measuring had not shown its settings since, whatever it failed of in the end.
  kSensorRecovered = 4,  // A sensor answers again: index = IMU, value = its WHO_AM_I, 0 in logs of earlier firmware.
  kCardStall = 5,  // A card write took long: value = milliseconds.
  kSamplesDropped = 6,  // The ring was full: value = samples lost.
  kRelease = 7,  // The logger detected a release, see [release]; time = its t = 0, arg = 1. arg = 0: a false release, both switches closed again.
  kLanding = 8,  // The robot has landed: arg = 1 by a shock, value = mg; arg = 0 by the time since the release.
  kRingHighWater = 9,  // More of the ring than ever waits for the card: arg = quarters of the ring, value = blocks.
  kCardLost = 10,  // The card stopped answering: arg = error code. It is tried again for as long as the ring has room.
  kCardBack = 11,  // The card takes blocks again: value = milliseconds that it was gone.
  kRewritten = 12,  // The last seconds were written a second time: value = blocks.
  kSamplingLate = 13,  // Ticks of the sampling timer passed without a sample: value = microseconds since the sample before.
  kSensorMissed = 15,  // A transfer from a running IMU failed; its reading is missing until it has shown that it kept its settings, most often this one only: index = IMU, arg = error code. One that stays away for 20 ms is a sensor_fault.
};

// Why a request was refused, what that means and what to do.
enum class ErrorCode : uint8_t {
  kNone = 0,  // No error.
  kUnknownMessage = 1,  // The board does not know this request.
  kBadLength = 2,  // The request has the wrong length.
  kWrongState = 3,  // The request is not allowed in the board's present state.
  kNoStagedManeuver = 4,  // A step or a commit came without a begin.
  kStepMissing = 5,  // The maneuver was committed before all its steps had arrived.
  kCrcMismatch = 6,  // The maneuver's CRC does not match its steps.
  kTooManyStrokes = 7,  // The maneuver has no stroke, or more than the board can hold.
  kJointUnknown = 8,  // A stroke names a joint that does not exist.
  kAngleOutOfRange = 9,  // A stroke would take a joint outside 0 to 90 deg, or moves nothing.
  kStrokesOverlap = 10,  // A stroke starts before its joint has ended the one before.
  kTooEarly = 11,  // A stroke starts before the pause is over.
  kTooLong = 12,  // The maneuver would outlast the fall.
  kSpeedOutOfRange = 13,  // The joint speed is outside 10 to 400 deg/s.
  kStoreFailed = 14,  // The EEPROM did not keep what was written.
  kSwitchOpen = 15,  // A release switch is open.
  kNoManeuver = 16,  // No valid maneuver was uploaded.
  kStaleToken = 17,  // The request belongs to an earlier state of the board.
  kFaultLatched = 18,  // A fault is latched.
  kIndexOutOfRange = 19,  // A step index is beyond the maneuver's end.
  kStrokeMissed = 20,  // A stroke was scheduled, but no pulse of it came out on the servo's pin.
  kNotAtStartPose = 21,  // A joint is not at its start pose.
  kResetWhileArmed = 22,  // The board restarted while it was armed, and a switch was open.
  kResetWhileRunning = 23,  // The board restarted while the maneuver ran.
  kJogNotConfirmed = 24,  // The jog did not carry its flag.
  kSettingOutOfRange = 25,  // A servo setting makes no sense.
  kSettingsDoNotFit = 26,  // The stored maneuver leaves a joint's limits in the servo settings.
  kStoreDamaged = 27,  // The stored maneuver or the servo settings are damaged in the EEPROM.
  kClosedWhileRunning = 28,  // Both release switches closed again after the maneuver had begun.
  kUploadInterrupted = 29,  // An upload of the maneuver or of the servo settings was begun and never completed.
  kStoreOldLayout = 30,  // The stored maneuver or the servo settings were stored by an earlier firmware, in another layout.
  kStartsTooClose = 31,  // A stroke starts before the one before it, or less than 10 ms after it.
  kTooManyMoving = 32,  // The stored maneuver moves more joints at once than the servo settings allow.
  kNoCard = 40,  // No SD card answers.
  kCardFull = 41,  // The card has no room for a recording, or holds DROP9999.BIN, the last number.
  kCardWriteFailed = 42,  // The card refused a write.
  kSensorMissing = 43,  // An IMU does not answer.
  kBusStuck = 44,  // An I2C bus is held low.
  kNotRecording = 45,  // There is no recording to stop.
  kSensorFrozen = 46,  // An IMU repeats the same reading.
  kSensorForeign = 47,  // What answers at an IMU's address is no part that the logger knows (WHO_AM_I), or does not keep its settings.
  kCardWriteProtected = 48,  // The card forbids writing.
  kCardUnreadable = 49,  // The card has no file system that the logger knows.
  kRateTooHigh = 50,  // The I2C buses cannot carry this sampling rate.
  kLoggerSettingOutOfRange = 51,  // A setting of the logger makes no sense.
  kNoSuchLog = 52,  // There is no such recording.
  kLogChanged = 53,  // The recording under this number is another than the one asked for.
  kRamHoldsDrop = 54,  // The logger's RAM holds a drop that no card has.
  kBusy = 55,  // The logger is counting the free room of a card that it has just met.
  kSensorReset = 57,  // An IMU has lost its settings.
};

// One 14-byte burst of an MPU-6050, registers 0x3B to 0x48 (RM-MPU-6000A rev. 4.2, p. 29-32), raw counts.
struct ImuReading {
  static constexpr size_t kSize = 14;

  int16_t accel[3];  // Specific force x, y, z.
  int16_t temperature;  // Die temperature: counts / temperature_lsb_per_c + temperature_offset_c.
  int16_t gyro[3];  // Angular rate x, y, z.

  void write(Writer& out) const {
    for (size_t i = 0; i < 3; ++i) out.i16(accel[i]);
    out.i16(temperature);
    for (size_t i = 0; i < 3; ++i) out.i16(gyro[i]);
  }

  void read(Reader& in) {
    for (size_t i = 0; i < 3; ++i) accel[i] = in.i16();
    temperature = in.i16();
    for (size_t i = 0; i < 3; ++i) gyro[i] = in.i16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ImuReading) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// All sensors, each read at the sample's time and its offset in LogHeader.
struct Sample {
  static constexpr size_t kSize = 74;

  uint32_t time_offset_us;  // Time after the block's time_us.
  uint16_t flags;  // Bits 0-3: IMU 1-4 valid; 4-9: angle sensor 1-6 valid; 10, 11: release switch 1, 2 open; 12-15: IMU 1-4 clipped.
  ImuReading imu[4];  // Bodies 1 to 4.
  uint16_t angle[6];  // Absolute angle sensors, ADC counts: joint 1 (two sensors), joint 2, joint 3.

  void write(Writer& out) const {
    out.u32(time_offset_us);
    out.u16(flags);
    for (size_t i = 0; i < 4; ++i) imu[i].write(out);
    for (size_t i = 0; i < 6; ++i) out.u16(angle[i]);
  }

  void read(Reader& in) {
    time_offset_us = in.u32();
    flags = in.u16();
    for (size_t i = 0; i < 4; ++i) imu[i].read(in);
    for (size_t i = 0; i < 6; ++i) angle[i] = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(Sample) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Something that happened, with its own time.
struct Event {
  static constexpr size_t kSize = 16;

  uint64_t time_us;  // The logger's clock, since power-up.
  EventCode code;  // What happened.
  uint8_t index;  // Which one; see EventCode.
  uint16_t arg;  // See EventCode.
  int32_t value;  // See EventCode.

  void write(Writer& out) const {
    out.u64(time_us);
    out.u8(static_cast<uint8_t>(code));
    out.u8(index);
    out.u16(arg);
    out.i32(value);
  }

  void read(Reader& in) {
    time_us = in.u64();
    code = static_cast<EventCode>(in.u8());
    index = in.u8();
    arg = in.u16();
    value = in.i32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(Event) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// How a joint's servo turns pulses into angles, and how far it may go.
struct ServoSetting {
  static constexpr size_t kSize = 9;

  uint16_t zero_us;  // Pulse width that holds 0 deg.
  uint16_t ns_per_deg;  // Change of pulse width for each degree.
  uint8_t reversed;  // 1: shorter pulses open the joint.
  int16_t min_cdeg;  // Least angle that may be commanded.
  int16_t max_cdeg;  // Greatest angle that may be commanded.

  void write(Writer& out) const {
    out.u16(zero_us);
    out.u16(ns_per_deg);
    out.u8(reversed);
    out.i16(min_cdeg);
    out.i16(max_cdeg);
  }

  void read(Reader& in) {
    zero_us = in.u16();
    ns_per_deg = in.u16();
    reversed = in.u8();
    min_cdeg = in.i16();
    max_cdeg = in.i16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ServoSetting) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// The first 32 bytes of every block.
struct BlockHeader {
  static constexpr size_t kSize = 32;

  uint32_t magic;  // block_magic.
  uint8_t version;  // block_version.
  BlockKind kind;  // What the block holds.
  uint8_t sample_count;  // Sample slots in use.
  uint8_t event_count;  // Event slots in use.
  uint32_t session;  // Random id of the recording.
  uint32_t block_number;  // From 0, without gaps in a recording.
  uint32_t first_sample;  // Index of the block's first sample in the recording, counting dropped ones too.
  uint32_t samples_dropped;  // Samples lost so far because the ring was full.
  uint64_t time_us;  // The logger's clock at the block's first sample, since power-up.

  void write(Writer& out) const {
    out.u32(magic);
    out.u8(version);
    out.u8(static_cast<uint8_t>(kind));
    out.u8(sample_count);
    out.u8(event_count);
    out.u32(session);
    out.u32(block_number);
    out.u32(first_sample);
    out.u32(samples_dropped);
    out.u64(time_us);
  }

  void read(Reader& in) {
    magic = in.u32();
    version = in.u8();
    kind = static_cast<BlockKind>(in.u8());
    sample_count = in.u8();
    event_count = in.u8();
    session = in.u32();
    block_number = in.u32();
    first_sample = in.u32();
    samples_dropped = in.u32();
    time_us = in.u64();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(BlockHeader) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// What was recorded, with which scales. Payload of a header block.
struct LogHeader {
  static constexpr size_t kSize = 475;

  uint8_t protocol_hash[8];  // Of the specification that the firmware was built with.
  uint8_t firmware_version[3];  // Major, minor, patch.
  uint8_t imu_present;  // Bits 0-3: IMU 1-4 answered at the start.
  uint8_t board_serial[8];  // The logger's serial number.
  uint32_t image_crc;  // CRC-32/ISO-HDLC of the flashed image.
  float rate_hz;  // Commanded sampling rate.
  float gyro_lsb_per_deg_s;  // Gyro scale.
  float accel_lsb_per_g;  // Accelerometer scale.
  float temperature_lsb_per_c;  // Temperature scale of an MPU-6050; of the other parts see IMUs.
  float temperature_offset_c;  // Temperature of an MPU-6050 at zero counts.
  uint32_t angle_counts_per_turn;  // ADC counts of a full turn of an angle sensor.
  uint16_t gyro_range_deg_s;  // Full scale, +-.
  uint8_t accel_range_g;  // Full scale, +-.
  uint8_t dlpf_cfg;  // Low-pass of the IMUs, CONFIG.DLPF_CFG; see IMUs.
  uint8_t who_am_i[4];  // Register 0x75 of each IMU; 0 where none answered.
  uint16_t bus_khz;  // Clock of the I2C buses.
  uint16_t after_landing_s;  // The recording closes by itself this long after the landing.
  uint8_t schema[384];  // This layout in words, ASCII, padded with zeros: a file found in ten years explains itself.
  uint64_t wall_clock_us;  // Unix time at time_us, if the host set the clock; else 0.
  uint16_t imu_offset_us[4];  // From a sample's time to the moment of each IMU's reading. 0 in logs of block_version 2, which do not tell it.
  uint16_t angle_offset_us[6];  // The same of each angle sensor.
  uint8_t maneuver_known;  // 1: the next field is known. 0 also in logs of firmware that does not tell it.
  uint16_t maneuver_crc;  // Of the maneuver that the sequencer held when the recording was started, as in maneuver_info.

  void write(Writer& out) const {
    for (size_t i = 0; i < 8; ++i) out.u8(protocol_hash[i]);
    for (size_t i = 0; i < 3; ++i) out.u8(firmware_version[i]);
    out.u8(imu_present);
    for (size_t i = 0; i < 8; ++i) out.u8(board_serial[i]);
    out.u32(image_crc);
    out.f32(rate_hz);
    out.f32(gyro_lsb_per_deg_s);
    out.f32(accel_lsb_per_g);
    out.f32(temperature_lsb_per_c);
    out.f32(temperature_offset_c);
    out.u32(angle_counts_per_turn);
    out.u16(gyro_range_deg_s);
    out.u8(accel_range_g);
    out.u8(dlpf_cfg);
    for (size_t i = 0; i < 4; ++i) out.u8(who_am_i[i]);
    out.u16(bus_khz);
    out.u16(after_landing_s);
    for (size_t i = 0; i < 384; ++i) out.u8(schema[i]);
    out.u64(wall_clock_us);
    for (size_t i = 0; i < 4; ++i) out.u16(imu_offset_us[i]);
    for (size_t i = 0; i < 6; ++i) out.u16(angle_offset_us[i]);
    out.u8(maneuver_known);
    out.u16(maneuver_crc);
  }

  void read(Reader& in) {
    for (size_t i = 0; i < 8; ++i) protocol_hash[i] = in.u8();
    for (size_t i = 0; i < 3; ++i) firmware_version[i] = in.u8();
    imu_present = in.u8();
    for (size_t i = 0; i < 8; ++i) board_serial[i] = in.u8();
    image_crc = in.u32();
    rate_hz = in.f32();
    gyro_lsb_per_deg_s = in.f32();
    accel_lsb_per_g = in.f32();
    temperature_lsb_per_c = in.f32();
    temperature_offset_c = in.f32();
    angle_counts_per_turn = in.u32();
    gyro_range_deg_s = in.u16();
    accel_range_g = in.u8();
    dlpf_cfg = in.u8();
    for (size_t i = 0; i < 4; ++i) who_am_i[i] = in.u8();
    bus_khz = in.u16();
    after_landing_s = in.u16();
    for (size_t i = 0; i < 384; ++i) schema[i] = in.u8();
    wall_clock_us = in.u64();
    for (size_t i = 0; i < 4; ++i) imu_offset_us[i] = in.u16();
    for (size_t i = 0; i < 6; ++i) angle_offset_us[i] = in.u16();
    maneuver_known = in.u8();
    maneuver_crc = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogHeader) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Summary written when a recording is closed cleanly. Payload of a footer block.
struct LogFooter {
  static constexpr size_t kSize = 45;

  uint32_t samples;  // Samples taken, dropped ones included.
  uint32_t samples_dropped;  // Samples lost because the ring was full.
  uint32_t blocks;  // Blocks of the recording, this one included.
  uint32_t ring_peak_blocks;  // Most blocks that ever waited for the card.
  uint32_t interval_min_us;  // Shortest time between two samples.
  uint32_t interval_max_us;  // Longest time between two samples.
  float jitter_rms_us;  // Root mean square of how far the times between samples were from the nominal one.
  uint32_t late_ticks;  // Times between samples over one and a half nominal ones: ticks without a sample.
  uint32_t ring_blocks;  // Blocks that the ring can hold.
  uint32_t card_stall_max_ms;  // Longest time that the card took nothing.
  uint32_t blocks_rewritten;  // Blocks that were written a second time after the landing.
  StopReason stop_reason;  // Why the recording ended.

  void write(Writer& out) const {
    out.u32(samples);
    out.u32(samples_dropped);
    out.u32(blocks);
    out.u32(ring_peak_blocks);
    out.u32(interval_min_us);
    out.u32(interval_max_us);
    out.f32(jitter_rms_us);
    out.u32(late_ticks);
    out.u32(ring_blocks);
    out.u32(card_stall_max_ms);
    out.u32(blocks_rewritten);
    out.u8(static_cast<uint8_t>(stop_reason));
  }

  void read(Reader& in) {
    samples = in.u32();
    samples_dropped = in.u32();
    blocks = in.u32();
    ring_peak_blocks = in.u32();
    interval_min_us = in.u32();
    interval_max_us = in.u32();
    jitter_rms_us = in.f32();
    late_ticks = in.u32();
    ring_blocks = in.u32();
    card_stall_max_ms = in.u32();
    blocks_rewritten = in.u32();
    stop_reason = static_cast<StopReason>(in.u8());
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogFooter) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// How the logger samples and records.
struct LoggerSettings {
  static constexpr size_t kSize = 12;

  uint16_t rate_hz;  // Sampling rate.
  uint16_t gyro_range_deg_s;  // Full scale, +-: 250, 500, 1000 or 2000.
  uint8_t accel_range_g;  // Full scale, +-: 2, 4, 8 or 16.
  uint8_t dlpf_cfg;  // Low-pass of the IMUs, CONFIG.DLPF_CFG, 0 to 6: 256, 188, 98, 42, 20, 10, 5 Hz.
  uint16_t bus_khz;  // Clock of the I2C buses: 100 or 400.
  uint16_t after_landing_s;  // A recording closes by itself this long after the landing.
  uint16_t file_mib;  // Room that a recording takes on the card.

  void write(Writer& out) const {
    out.u16(rate_hz);
    out.u16(gyro_range_deg_s);
    out.u8(accel_range_g);
    out.u8(dlpf_cfg);
    out.u16(bus_khz);
    out.u16(after_landing_s);
    out.u16(file_mib);
  }

  void read(Reader& in) {
    rate_hz = in.u16();
    gyro_range_deg_s = in.u16();
    accel_range_g = in.u8();
    dlpf_cfg = in.u8();
    bus_khz = in.u16();
    after_landing_s = in.u16();
    file_mib = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LoggerSettings) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// A recording that the logger can hand over.
struct LogEntry {
  static constexpr size_t kSize = 19;

  uint16_t number;  // Of its file, DROP0001.BIN and up; 0 is what RAM holds.
  uint32_t session;  // Random id of the recording; 0: its first block says nothing.
  uint32_t blocks;  // Blocks of the file; unused room included where it was not closed.
  uint64_t wall_clock_us;  // Unix time of its start, or 0.
  uint8_t closed;  // 1: its last block is its footer.

  void write(Writer& out) const {
    out.u16(number);
    out.u32(session);
    out.u32(blocks);
    out.u64(wall_clock_us);
    out.u8(closed);
  }

  void read(Reader& in) {
    number = in.u16();
    session = in.u32();
    blocks = in.u32();
    wall_clock_us = in.u64();
    closed = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogEntry) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Who are you? Its number and layout never change, so that any two revisions understand it.
struct HelloRequest {
  static constexpr uint8_t kType = 0x01;
  static constexpr size_t kSize = 0;
};

// Who are you? Its number and layout never change, so that any two revisions understand it.
struct HelloReply {
  static constexpr uint8_t kType = 0x81;
  static constexpr size_t kSize = 24;

  Board board;  // Kind of board.
  uint8_t firmware_version[3];  // Major, minor, patch.
  uint8_t board_serial[8];  // Serial number of the chip; zeros where it has none.
  uint32_t image_crc;  // CRC-32/ISO-HDLC of the flashed image, computed by the board.
  uint8_t protocol_hash[8];  // Hash of this specification.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(board));
    for (size_t i = 0; i < 3; ++i) out.u8(firmware_version[i]);
    for (size_t i = 0; i < 8; ++i) out.u8(board_serial[i]);
    out.u32(image_crc);
    for (size_t i = 0; i < 8; ++i) out.u8(protocol_hash[i]);
  }

  void read(Reader& in) {
    board = static_cast<Board>(in.u8());
    for (size_t i = 0; i < 3; ++i) firmware_version[i] = in.u8();
    for (size_t i = 0; i < 8; ++i) board_serial[i] = in.u8();
    image_crc = in.u32();
    for (size_t i = 0; i < 8; ++i) protocol_hash[i] = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(HelloReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// What the sequencer is doing.
struct SequencerStatusRequest {
  static constexpr uint8_t kType = 0x02;
  static constexpr size_t kSize = 0;
};

// What the sequencer is doing.
struct SequencerStatusReply {
  static constexpr uint8_t kType = 0x82;
  static constexpr size_t kSize = 34;

  SequencerState state;  // State machine.
  ErrorCode fault;  // The latched fault, or none.
  ErrorCode last_refusal;  // Why ARM was last refused, or none.
  uint8_t switches_open;  // Bit 0, 1: release switch 1, 2 is open.
  uint16_t arm_token;  // To be given to ARM; changes at each change of state.
  ResetCause reset_cause;  // Why the board last started.
  uint8_t resets_while_armed;  // Restarts that this arming has survived; 255 stands for more.
  uint8_t strokes_started;  // Strokes of the last run that have begun: a whole pulse of the new width was on the servo's pin.
  uint16_t knocks;  // False triggers since arming, see [release]; kept over a reset.
  int16_t joint_angle_cdeg[3];  // Angle that each servo is told to hold; 0 where it gets no pulses.
  uint32_t uptime_ms;  // Since the board started.
  uint32_t image_crc;  // CRC-32/ISO-HDLC of the flashed image.
  uint16_t ram_never_used_bytes;  // Low-water mark of free RAM since the board started.
  uint16_t frames_rejected;  // Frames that arrived damaged, since the board started.
  uint8_t stores_damaged;  // Why ARM is refused for what is stored; even bits for the maneuver, odd ones for the servo settings. Bit 0, 1: store_damaged; 2, 3: upload_interrupted; 4, 5: store_old_layout.
  uint16_t false_releases;  // False releases since arming, see [release]; kept over a reset.
  uint8_t servos_driven;  // Bit 0, 1, 2: the servo of joint 1, 2, 3 gets pulses; else it is limp.
  uint8_t brown_out_level;  // The fuse BODLEVEL: the supply below which the processor is held in reset (ATmega32U4 datasheet 7766J, table 8-1). 0: 4.3 V; 1: 3.5; 2: 3.4; 3: 2.6; 4: 2.4; 5: 2.2; 6: 2.0; 7: it never is.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(state));
    out.u8(static_cast<uint8_t>(fault));
    out.u8(static_cast<uint8_t>(last_refusal));
    out.u8(switches_open);
    out.u16(arm_token);
    out.u8(static_cast<uint8_t>(reset_cause));
    out.u8(resets_while_armed);
    out.u8(strokes_started);
    out.u16(knocks);
    for (size_t i = 0; i < 3; ++i) out.i16(joint_angle_cdeg[i]);
    out.u32(uptime_ms);
    out.u32(image_crc);
    out.u16(ram_never_used_bytes);
    out.u16(frames_rejected);
    out.u8(stores_damaged);
    out.u16(false_releases);
    out.u8(servos_driven);
    out.u8(brown_out_level);
  }

  void read(Reader& in) {
    state = static_cast<SequencerState>(in.u8());
    fault = static_cast<ErrorCode>(in.u8());
    last_refusal = static_cast<ErrorCode>(in.u8());
    switches_open = in.u8();
    arm_token = in.u16();
    reset_cause = static_cast<ResetCause>(in.u8());
    resets_while_armed = in.u8();
    strokes_started = in.u8();
    knocks = in.u16();
    for (size_t i = 0; i < 3; ++i) joint_angle_cdeg[i] = in.i16();
    uptime_ms = in.u32();
    image_crc = in.u32();
    ram_never_used_bytes = in.u16();
    frames_rejected = in.u16();
    stores_damaged = in.u8();
    false_releases = in.u16();
    servos_driven = in.u8();
    brown_out_level = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(SequencerStatusReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// The last run, as measured by the sequencer's own timer.
struct RunReportRequest {
  static constexpr uint8_t kType = 0x04;
  static constexpr size_t kSize = 0;
};

// The last run, as measured by the sequencer's own timer.
struct RunReportReply {
  static constexpr uint8_t kType = 0x84;
  static constexpr size_t kSize = 82;

  uint8_t released;  // 1: a run since power was switched on; 0: none, all other fields are zero.
  uint16_t bounces;  // Edges of both switches from the release's first edge to its confirmation.
  uint32_t release_ms;  // Time of the release edge by the clock of uptime_ms, whole milliseconds; after a reset: by the clock before it.
  uint16_t release_us;  // Microseconds of that time beyond the whole milliseconds, 0 to 999.
  uint8_t stroke_count;  // Strokes of the maneuver that flew.
  uint32_t start_us[16];  // Of each stroke: from the release edge to the rise of the first whole pulse of its width on the pin, 0.5 us rounded down; or stroke_not_begun_us, stroke_time_unknown_us. Late if the pin was held from outside.
  uint32_t earlier_us;  // The robot may have left up to this long before the release edge; 0 unless the edges, or those that were lost, fit two releases.
  uint32_t later_us;  // And so long after it.

  void write(Writer& out) const {
    out.u8(released);
    out.u16(bounces);
    out.u32(release_ms);
    out.u16(release_us);
    out.u8(stroke_count);
    for (size_t i = 0; i < 16; ++i) out.u32(start_us[i]);
    out.u32(earlier_us);
    out.u32(later_us);
  }

  void read(Reader& in) {
    released = in.u8();
    bounces = in.u16();
    release_ms = in.u32();
    release_us = in.u16();
    stroke_count = in.u8();
    for (size_t i = 0; i < 16; ++i) start_us[i] = in.u32();
    earlier_us = in.u32();
    later_us = in.u32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(RunReportReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// What the logger is doing.
struct LoggerStatusRequest {
  static constexpr uint8_t kType = 0x03;
  static constexpr size_t kSize = 0;
};

// What the logger is doing.
struct LoggerStatusReply {
  static constexpr uint8_t kType = 0x83;
  static constexpr size_t kSize = 57;

  LoggerState state;  // State.
  ErrorCode error;  // Why the last recording failed, or none.
  uint8_t imu_present;  // Bits 0-3: IMU 1-4 answers now.
  uint8_t switches_open;  // Bit 0, 1: release switch 1, 2 is open.
  uint32_t session;  // Of the present or last recording; 0 before the first.
  uint32_t samples;  // Samples of that recording.
  uint32_t samples_dropped;  // Of those, lost because the ring was full.
  uint32_t blocks_written;  // Blocks handed to the card.
  uint16_t ring_blocks;  // Blocks that wait for the card.
  uint16_t ring_peak_blocks;  // Most that ever waited.
  uint16_t rate_hz;  // Sampling rate.
  uint8_t who_am_i[4];  // Register 0x75 of each IMU.
  uint32_t uptime_ms;  // Since the board started.
  CardState card;  // The card, looked at every two seconds while nothing is recorded.
  uint32_t card_free_mib;  // Free room on it, counted when the logger met it and after each recording.
  DropPhase phase;  // Of the present or last recording.
  uint8_t ram_holds_drop;  // 1: RAM holds a drop that no card has. Keep the power on and fetch it.
  uint32_t late_ticks;  // Ticks of the sampling timer without a sample, since the board started.
  Origin settings_origin;  // Of the settings in force.
  uint64_t unix_us;  // Time of day, or 0 when no host has set it.
  uint8_t maneuver_known;  // 1: the next field is known.
  uint16_t maneuver_crc;  // Of the maneuver in the header of the present or last recording; see LogHeader.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(state));
    out.u8(static_cast<uint8_t>(error));
    out.u8(imu_present);
    out.u8(switches_open);
    out.u32(session);
    out.u32(samples);
    out.u32(samples_dropped);
    out.u32(blocks_written);
    out.u16(ring_blocks);
    out.u16(ring_peak_blocks);
    out.u16(rate_hz);
    for (size_t i = 0; i < 4; ++i) out.u8(who_am_i[i]);
    out.u32(uptime_ms);
    out.u8(static_cast<uint8_t>(card));
    out.u32(card_free_mib);
    out.u8(static_cast<uint8_t>(phase));
    out.u8(ram_holds_drop);
    out.u32(late_ticks);
    out.u8(static_cast<uint8_t>(settings_origin));
    out.u64(unix_us);
    out.u8(maneuver_known);
    out.u16(maneuver_crc);
  }

  void read(Reader& in) {
    state = static_cast<LoggerState>(in.u8());
    error = static_cast<ErrorCode>(in.u8());
    imu_present = in.u8();
    switches_open = in.u8();
    session = in.u32();
    samples = in.u32();
    samples_dropped = in.u32();
    blocks_written = in.u32();
    ring_blocks = in.u16();
    ring_peak_blocks = in.u16();
    rate_hz = in.u16();
    for (size_t i = 0; i < 4; ++i) who_am_i[i] = in.u8();
    uptime_ms = in.u32();
    card = static_cast<CardState>(in.u8());
    card_free_mib = in.u32();
    phase = static_cast<DropPhase>(in.u8());
    ram_holds_drop = in.u8();
    late_ticks = in.u32();
    settings_origin = static_cast<Origin>(in.u8());
    unix_us = in.u64();
    maneuver_known = in.u8();
    maneuver_crc = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LoggerStatusReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Starts an upload. The stored maneuver stays until commit, but ARM is refused (upload_interrupted) from here on, power cuts included.
struct ManeuverBeginRequest {
  static constexpr uint8_t kType = 0x10;
  static constexpr size_t kSize = 3;

  uint8_t stroke_count;  // Strokes that follow.
  uint16_t speed_cdeg_s;  // Average joint speed that the schedule assumes, 0.01 deg/s.

  void write(Writer& out) const {
    out.u8(stroke_count);
    out.u16(speed_cdeg_s);
  }

  void read(Reader& in) {
    stroke_count = in.u8();
    speed_cdeg_s = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ManeuverBeginRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Starts an upload. The stored maneuver stays until commit, but ARM is refused (upload_interrupted) from here on, power cuts included.
struct ManeuverBeginReply {
  static constexpr uint8_t kType = 0x90;
  static constexpr size_t kSize = 1;

  uint8_t stroke_count;  // As understood.

  void write(Writer& out) const {
    out.u8(stroke_count);
  }

  void read(Reader& in) {
    stroke_count = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ManeuverBeginReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// One stroke of the upload.
struct ManeuverStrokeRequest {
  static constexpr uint8_t kType = 0x11;
  static constexpr size_t kSize = 8;

  uint8_t index;  // From 0.
  uint8_t joint;  // 1 to 3.
  int16_t angle_cdeg;  // Displacement, 0.01 deg.
  uint32_t start_us;  // Start after release.

  void write(Writer& out) const {
    out.u8(index);
    out.u8(joint);
    out.i16(angle_cdeg);
    out.u32(start_us);
  }

  void read(Reader& in) {
    index = in.u8();
    joint = in.u8();
    angle_cdeg = in.i16();
    start_us = in.u32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ManeuverStrokeRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// One stroke of the upload.
struct ManeuverStrokeReply {
  static constexpr uint8_t kType = 0x91;
  static constexpr size_t kSize = 1;

  uint8_t index;  // As understood.

  void write(Writer& out) const {
    out.u8(index);
  }

  void read(Reader& in) {
    index = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ManeuverStrokeReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Checks the whole maneuver and stores it. EEPROM is slow: the host repeats the commit until `stored` is 1.
struct ManeuverCommitRequest {
  static constexpr uint8_t kType = 0x12;
  static constexpr size_t kSize = 2;

  uint16_t crc;  // CRC-16/IBM-3740 over stroke_count, speed_cdeg_s and each stroke's joint, angle_cdeg, start_us.

  void write(Writer& out) const {
    out.u16(crc);
  }

  void read(Reader& in) {
    crc = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ManeuverCommitRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Checks the whole maneuver and stores it. EEPROM is slow: the host repeats the commit until `stored` is 1.
struct ManeuverCommitReply {
  static constexpr uint8_t kType = 0x92;
  static constexpr size_t kSize = 2;

  uint8_t stored;  // 0: still writing. 1: stored, checked by reading back.
  uint8_t written;  // 1: this upload changed the store. 0: it held the same maneuver already.

  void write(Writer& out) const {
    out.u8(stored);
    out.u8(written);
  }

  void read(Reader& in) {
    stored = in.u8();
    written = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ManeuverCommitReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Which maneuver would fly.
struct ManeuverInfoRequest {
  static constexpr uint8_t kType = 0x13;
  static constexpr size_t kSize = 0;
};

// Which maneuver would fly.
struct ManeuverInfoReply {
  static constexpr uint8_t kType = 0x93;
  static constexpr size_t kSize = 14;

  Origin origin;  // Factory or uploaded.
  uint8_t stroke_count;  // Strokes.
  uint16_t speed_cdeg_s;  // Average joint speed, 0.01 deg/s.
  uint16_t crc;  // As in maneuver_commit, computed from what would fly.
  uint32_t end_us;  // When the last stroke ends.
  uint32_t generation;  // Uploads that this board has stored.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(origin));
    out.u8(stroke_count);
    out.u16(speed_cdeg_s);
    out.u16(crc);
    out.u32(end_us);
    out.u32(generation);
  }

  void read(Reader& in) {
    origin = static_cast<Origin>(in.u8());
    stroke_count = in.u8();
    speed_cdeg_s = in.u16();
    crc = in.u16();
    end_us = in.u32();
    generation = in.u32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ManeuverInfoReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Reads one stroke back from what would fly.
struct ManeuverReadRequest {
  static constexpr uint8_t kType = 0x14;
  static constexpr size_t kSize = 1;

  uint8_t index;  // From 0.

  void write(Writer& out) const {
    out.u8(index);
  }

  void read(Reader& in) {
    index = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ManeuverReadRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Reads one stroke back from what would fly.
struct ManeuverReadReply {
  static constexpr uint8_t kType = 0x94;
  static constexpr size_t kSize = 8;

  uint8_t index;  // As asked.
  uint8_t joint;  // 1 to 3.
  int16_t angle_cdeg;  // Displacement, 0.01 deg.
  uint32_t start_us;  // Start after release.

  void write(Writer& out) const {
    out.u8(index);
    out.u8(joint);
    out.i16(angle_cdeg);
    out.u32(start_us);
  }

  void read(Reader& in) {
    index = in.u8();
    joint = in.u8();
    angle_cdeg = in.i16();
    start_us = in.u32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ManeuverReadReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// From now on the release starts the maneuver.
struct ArmRequest {
  static constexpr uint8_t kType = 0x20;
  static constexpr size_t kSize = 2;

  uint16_t arm_token;  // From sequencer_status.

  void write(Writer& out) const {
    out.u16(arm_token);
  }

  void read(Reader& in) {
    arm_token = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ArmRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// From now on the release starts the maneuver.
struct ArmReply {
  static constexpr uint8_t kType = 0xA0;
  static constexpr size_t kSize = 1;

  SequencerState state;  // Afterwards.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(state));
  }

  void read(Reader& in) {
    state = static_cast<SequencerState>(in.u8());
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ArmReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Back to safe, from any state; stops the servo pulses and clears a latched fault.
struct DisarmRequest {
  static constexpr uint8_t kType = 0x21;
  static constexpr size_t kSize = 0;
};

// Back to safe, from any state; stops the servo pulses and clears a latched fault.
struct DisarmReply {
  static constexpr uint8_t kType = 0xA1;
  static constexpr size_t kSize = 1;

  SequencerState state;  // Afterwards.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(state));
  }

  void read(Reader& in) {
    state = static_cast<SequencerState>(in.u8());
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(DisarmReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Starts a recording, and sets the time of day. Refused by the card, it still goes on in RAM (state failed).
struct RecordStartRequest {
  static constexpr uint8_t kType = 0x40;
  static constexpr size_t kSize = 15;

  uint32_t number;  // Chosen at random by the host.
  uint64_t unix_us;  // Time of day; 0 leaves the clock as it is.
  uint8_t maneuver_known;  // 1: the next field is known.
  uint16_t maneuver_crc;  // Of the maneuver that the sequencer holds, for the header; see LogHeader.

  void write(Writer& out) const {
    out.u32(number);
    out.u64(unix_us);
    out.u8(maneuver_known);
    out.u16(maneuver_crc);
  }

  void read(Reader& in) {
    number = in.u32();
    unix_us = in.u64();
    maneuver_known = in.u8();
    maneuver_crc = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(RecordStartRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Starts a recording, and sets the time of day. Refused by the card, it still goes on in RAM (state failed).
struct RecordStartReply {
  static constexpr uint8_t kType = 0xC0;
  static constexpr size_t kSize = 5;

  LoggerState state;  // Afterwards.
  uint32_t session;  // Random id of the recording.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(state));
    out.u32(session);
  }

  void read(Reader& in) {
    state = static_cast<LoggerState>(in.u8());
    session = in.u32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(RecordStartReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Ends the recording with a footer. The host repeats it until the state is stopped.
struct RecordStopRequest {
  static constexpr uint8_t kType = 0x41;
  static constexpr size_t kSize = 0;
};

// Ends the recording with a footer. The host repeats it until the state is stopped.
struct RecordStopReply {
  static constexpr uint8_t kType = 0xC1;
  static constexpr size_t kSize = 13;

  LoggerState state;  // stopping, then stopped.
  uint32_t session;  // Of the recording.
  uint32_t samples;  // Samples taken.
  uint32_t samples_dropped;  // Of those, lost.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(state));
    out.u32(session);
    out.u32(samples);
    out.u32(samples_dropped);
  }

  void read(Reader& in) {
    state = static_cast<LoggerState>(in.u8());
    session = in.u32();
    samples = in.u32();
    samples_dropped = in.u32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(RecordStopReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Switches live sampling on or off. It also ends when the cable is pulled.
struct LiveRequest {
  static constexpr uint8_t kType = 0x42;
  static constexpr size_t kSize = 1;

  uint8_t enabled;  // 1 on, 0 off.

  void write(Writer& out) const {
    out.u8(enabled);
  }

  void read(Reader& in) {
    enabled = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LiveRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Switches live sampling on or off. It also ends when the cable is pulled.
struct LiveReply {
  static constexpr uint8_t kType = 0xC2;
  static constexpr size_t kSize = 40;

  uint8_t enabled;  // As understood.
  uint16_t rate_hz;  // Sampling rate.
  float gyro_lsb_per_deg_s;  // Gyro scale.
  float accel_lsb_per_g;  // Accelerometer scale.
  uint32_t angle_counts_per_turn;  // Angle sensor scale.
  uint8_t dlpf_cfg;  // Low-pass of the IMUs, CONFIG.DLPF_CFG.
  uint8_t who_am_i[4];  // Register 0x75 of each IMU; 0 where none answered.
  uint16_t imu_offset_us[4];  // From a sample's time to the moment of each IMU's reading.
  uint16_t angle_offset_us[6];  // The same of each angle sensor.

  void write(Writer& out) const {
    out.u8(enabled);
    out.u16(rate_hz);
    out.f32(gyro_lsb_per_deg_s);
    out.f32(accel_lsb_per_g);
    out.u32(angle_counts_per_turn);
    out.u8(dlpf_cfg);
    for (size_t i = 0; i < 4; ++i) out.u8(who_am_i[i]);
    for (size_t i = 0; i < 4; ++i) out.u16(imu_offset_us[i]);
    for (size_t i = 0; i < 6; ++i) out.u16(angle_offset_us[i]);
  }

  void read(Reader& in) {
    enabled = in.u8();
    rate_hz = in.u16();
    gyro_lsb_per_deg_s = in.f32();
    accel_lsb_per_g = in.f32();
    angle_counts_per_turn = in.u32();
    dlpf_cfg = in.u8();
    for (size_t i = 0; i < 4; ++i) who_am_i[i] = in.u8();
    for (size_t i = 0; i < 4; ++i) imu_offset_us[i] = in.u16();
    for (size_t i = 0; i < 6; ++i) angle_offset_us[i] = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LiveReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Checks, stores and uses new settings; not while recording. rate_too_high: detail = the highest rate in Hz that the buses carry.
struct LoggerSettingsWriteRequest {
  static constexpr uint8_t kType = 0x45;
  static constexpr size_t kSize = 12;

  LoggerSettings settings;  // All of them.

  void write(Writer& out) const {
    settings.write(out);
  }

  void read(Reader& in) {
    settings.read(in);
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LoggerSettingsWriteRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Checks, stores and uses new settings; not while recording. rate_too_high: detail = the highest rate in Hz that the buses carry.
struct LoggerSettingsWriteReply {
  static constexpr uint8_t kType = 0xC5;
  static constexpr size_t kSize = 1;

  uint8_t stored;  // 1: stored, checked by reading back.

  void write(Writer& out) const {
    out.u8(stored);
  }

  void read(Reader& in) {
    stored = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LoggerSettingsWriteReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// The settings in force.
struct LoggerSettingsReadRequest {
  static constexpr uint8_t kType = 0x46;
  static constexpr size_t kSize = 0;
};

// The settings in force.
struct LoggerSettingsReadReply {
  static constexpr uint8_t kType = 0xC6;
  static constexpr size_t kSize = 15;

  Origin origin;  // Factory or uploaded.
  LoggerSettings settings;  // All of them.
  uint16_t rate_max_hz;  // What the buses carry at this clock.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(origin));
    settings.write(out);
    out.u16(rate_max_hz);
  }

  void read(Reader& in) {
    origin = static_cast<Origin>(in.u8());
    settings.read(in);
    rate_max_hz = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LoggerSettingsReadReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Sets the time of day.
struct ClockSetRequest {
  static constexpr uint8_t kType = 0x47;
  static constexpr size_t kSize = 8;

  uint64_t unix_us;  // Unix time now.

  void write(Writer& out) const {
    out.u64(unix_us);
  }

  void read(Reader& in) {
    unix_us = in.u64();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ClockSetRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Sets the time of day.
struct ClockSetReply {
  static constexpr uint8_t kType = 0xC7;
  static constexpr size_t kSize = 8;

  uint64_t uptime_us;  // The logger's clock at that moment.

  void write(Writer& out) const {
    out.u64(uptime_us);
  }

  void read(Reader& in) {
    uptime_us = in.u64();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ClockSetReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// The first recording whose number is `from_number` or greater; not while recording.
struct LogListRequest {
  static constexpr uint8_t kType = 0x48;
  static constexpr size_t kSize = 2;

  uint16_t from_number;  // 0 to begin with what RAM holds.

  void write(Writer& out) const {
    out.u16(from_number);
  }

  void read(Reader& in) {
    from_number = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogListRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// The first recording whose number is `from_number` or greater; not while recording.
struct LogListReply {
  static constexpr uint8_t kType = 0xC8;
  static constexpr size_t kSize = 20;

  uint8_t found;  // 0: there is none, the rest is zero.
  LogEntry entry;  // The recording.

  void write(Writer& out) const {
    out.u8(found);
    entry.write(out);
  }

  void read(Reader& in) {
    found = in.u8();
    entry.read(in);
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogListReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Sends blocks of a recording as log_part and log_zeros; not while recording. A new log_read, or a closed port, ends the one before.
struct LogReadRequest {
  static constexpr uint8_t kType = 0x49;
  static constexpr size_t kSize = 12;

  uint16_t number;  // As in LogEntry.
  uint32_t session;  // As in LogEntry.
  uint32_t first_block;  // From 0.
  uint16_t count;  // At most log_read_blocks.

  void write(Writer& out) const {
    out.u16(number);
    out.u32(session);
    out.u32(first_block);
    out.u16(count);
  }

  void read(Reader& in) {
    number = in.u16();
    session = in.u32();
    first_block = in.u32();
    count = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogReadRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Sends blocks of a recording as log_part and log_zeros; not while recording. A new log_read, or a closed port, ends the one before.
struct LogReadReply {
  static constexpr uint8_t kType = 0xC9;
  static constexpr size_t kSize = 2;

  uint16_t count;  // Blocks that will be sent: fewer at the end of the file.

  void write(Writer& out) const {
    out.u16(count);
  }

  void read(Reader& in) {
    count = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogReadReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Removes a recording from the card; number 0: gives up what RAM holds. Not while recording.
struct LogEraseRequest {
  static constexpr uint8_t kType = 0x4A;
  static constexpr size_t kSize = 6;

  uint16_t number;  // As in LogEntry.
  uint32_t session;  // As in LogEntry.

  void write(Writer& out) const {
    out.u16(number);
    out.u32(session);
  }

  void read(Reader& in) {
    number = in.u16();
    session = in.u32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogEraseRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Removes a recording from the card; number 0: gives up what RAM holds. Not while recording.
struct LogEraseReply {
  static constexpr uint8_t kType = 0xCA;
  static constexpr size_t kSize = 1;

  uint8_t erased;  // 1.

  void write(Writer& out) const {
    out.u8(erased);
  }

  void read(Reader& in) {
    erased = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogEraseReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// A piece of a block, as asked for by log_read. A lost one is asked for again.
struct LogPartStream {
  static constexpr uint8_t kType = 0x61;
  static constexpr size_t kSize = 69;

  uint32_t block;  // Of the recording.
  uint8_t part;  // From 0.
  uint8_t data[64];  // log_part_bytes of the block.

  void write(Writer& out) const {
    out.u32(block);
    out.u8(part);
    for (size_t i = 0; i < 64; ++i) out.u8(data[i]);
  }

  void read(Reader& in) {
    block = in.u32();
    part = in.u8();
    for (size_t i = 0; i < 64; ++i) data[i] = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogPartStream) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Blocks that hold only zeros, as asked for by log_read.
struct LogZerosStream {
  static constexpr uint8_t kType = 0x62;
  static constexpr size_t kSize = 6;

  uint32_t first_block;  // Of the recording.
  uint16_t count;  // Blocks.

  void write(Writer& out) const {
    out.u32(first_block);
    out.u16(count);
  }

  void read(Reader& in) {
    first_block = in.u32();
    count = in.u16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LogZerosStream) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// One sample as it is taken; sent unasked while live sampling is on. What the host does not read in time is skipped and shows as a gap in the index.
struct LiveSampleStream {
  static constexpr uint8_t kType = 0x60;
  static constexpr size_t kSize = 86;

  uint32_t index;  // Of the sample since the board started.
  uint64_t time_us;  // The logger's clock, since power-up.
  Sample sample;  // time_offset_us is 0.

  void write(Writer& out) const {
    out.u32(index);
    out.u64(time_us);
    sample.write(out);
  }

  void read(Reader& in) {
    index = in.u32();
    time_us = in.u64();
    sample.read(in);
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(LiveSampleStream) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Answer to a request that was not served.
struct ErrorReply {
  static constexpr uint8_t kType = 0xFF;
  static constexpr size_t kSize = 6;

  uint8_t request;  // Type of the request.
  ErrorCode code;  // Why.
  int32_t detail;  // What the code refers to, such as the index of the stroke; -1 where nothing.

  void write(Writer& out) const {
    out.u8(request);
    out.u8(static_cast<uint8_t>(code));
    out.i32(detail);
  }

  void read(Reader& in) {
    request = in.u8();
    code = static_cast<ErrorCode>(in.u8());
    detail = in.i32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(ErrorReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Checks and stores the servo settings. The host repeats it until `stored` is 1, then reads back.
struct SettingsWriteRequest {
  static constexpr uint8_t kType = 0x15;
  static constexpr size_t kSize = 30;

  uint16_t frame_us;  // From pulse to pulse.
  ServoSetting servo[3];  // Joints 1 to 3.
  uint8_t moving_at_once;  // Joints that the supply can move at the same time, 1 to 3.

  void write(Writer& out) const {
    out.u16(frame_us);
    for (size_t i = 0; i < 3; ++i) servo[i].write(out);
    out.u8(moving_at_once);
  }

  void read(Reader& in) {
    frame_us = in.u16();
    for (size_t i = 0; i < 3; ++i) servo[i].read(in);
    moving_at_once = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(SettingsWriteRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Checks and stores the servo settings. The host repeats it until `stored` is 1, then reads back.
struct SettingsWriteReply {
  static constexpr uint8_t kType = 0x95;
  static constexpr size_t kSize = 2;

  uint8_t stored;  // 0: still writing. 1: stored, checked by reading back.
  uint8_t written;  // 1: storing these settings changed the store. 0: it held them already before they were sent.

  void write(Writer& out) const {
    out.u8(stored);
    out.u8(written);
  }

  void read(Reader& in) {
    stored = in.u8();
    written = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(SettingsWriteReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// The servo settings in force.
struct SettingsReadRequest {
  static constexpr uint8_t kType = 0x16;
  static constexpr size_t kSize = 0;
};

// The servo settings in force.
struct SettingsReadReply {
  static constexpr uint8_t kType = 0x96;
  static constexpr size_t kSize = 35;

  Origin origin;  // Factory or uploaded.
  uint32_t generation;  // Settings that this board has stored.
  uint16_t frame_us;  // From pulse to pulse.
  ServoSetting servo[3];  // Joints 1 to 3.
  uint8_t moving_at_once;  // Joints that the supply can move at the same time, 1 to 3.

  void write(Writer& out) const {
    out.u8(static_cast<uint8_t>(origin));
    out.u32(generation);
    out.u16(frame_us);
    for (size_t i = 0; i < 3; ++i) servo[i].write(out);
    out.u8(moving_at_once);
  }

  void read(Reader& in) {
    origin = static_cast<Origin>(in.u8());
    generation = in.u32();
    frame_us = in.u16();
    for (size_t i = 0; i < 3; ++i) servo[i].read(in);
    moving_at_once = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(SettingsReadReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// What the joint angles are, as the host has them from the logger. ARM heeds it while it is fresh.
struct JointReportRequest {
  static constexpr uint8_t kType = 0x22;
  static constexpr size_t kSize = 6;

  int16_t angle_cdeg[3];  // Joints 1 to 3, 0.01 deg.

  void write(Writer& out) const {
    for (size_t i = 0; i < 3; ++i) out.i16(angle_cdeg[i]);
  }

  void read(Reader& in) {
    for (size_t i = 0; i < 3; ++i) angle_cdeg[i] = in.i16();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(JointReportRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// What the joint angles are, as the host has them from the logger. ARM heeds it while it is fresh.
struct JointReportReply {
  static constexpr uint8_t kType = 0xA2;
  static constexpr size_t kSize = 1;

  uint8_t at_start_pose;  // 1: all within the tolerance.

  void write(Writer& out) const {
    out.u8(at_start_pose);
  }

  void read(Reader& in) {
    at_start_pose = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(JointReportReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Moves one joint slowly; from SAFE or an earlier jog only. A limp joint has no known angle: the host says where it is, so that the first pulse does not jerk it. DISARM, a closed port, or a while without orders ends it.
struct JogRequest {
  static constexpr uint8_t kType = 0x23;
  static constexpr size_t kSize = 9;

  uint8_t joint;  // 1 to 3.
  int16_t from_cdeg;  // Where the joint is; ignored while it is already being jogged.
  int16_t to_cdeg;  // Where it is to go; within its limits.
  uint32_t confirm;  // jog_confirm.

  void write(Writer& out) const {
    out.u8(joint);
    out.i16(from_cdeg);
    out.i16(to_cdeg);
    out.u32(confirm);
  }

  void read(Reader& in) {
    joint = in.u8();
    from_cdeg = in.i16();
    to_cdeg = in.i16();
    confirm = in.u32();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(JogRequest) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

// Moves one joint slowly; from SAFE or an earlier jog only. A limp joint has no known angle: the host says where it is, so that the first pulse does not jerk it. DISARM, a closed port, or a while without orders ends it.
struct JogReply {
  static constexpr uint8_t kType = 0xA3;
  static constexpr size_t kSize = 3;

  int16_t angle_cdeg;  // What the servo is told now.
  uint8_t arrived;  // 1: it is told the target.

  void write(Writer& out) const {
    out.i16(angle_cdeg);
    out.u8(arrived);
  }

  void read(Reader& in) {
    angle_cdeg = in.i16();
    arrived = in.u8();
  }

  // `out` must hold kSize bytes.
  void encode(uint8_t* out) const {
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    static_assert(sizeof(JogReply) == kSize, "no padding");
    memcpy(out, this, kSize);
#else
    Writer writer(out);
    write(writer);
#endif
  }

  // False, and nothing read, when the length is not kSize.
  bool decode(const uint8_t* in, size_t size) {
    if (size != kSize) return false;
#ifdef TFSAT_WIRE_FORM_IN_MEMORY
    memcpy(this, in, kSize);
#else
    Reader reader(in);
    read(reader);
#endif
    return true;
  }
};

}  // namespace protocol
}  // namespace tfsat

#endif

#include "maneuver.h"

#include <string.h>

#include "../protocol/crc16.h"

namespace tfsat {
namespace sequencer {

namespace {

uint16_t magnitude(int16_t angle_cdeg) {
  return static_cast<uint16_t>(angle_cdeg < 0 ? -static_cast<int32_t>(angle_cdeg) : angle_cdeg);
}

}  // namespace

Maneuver Maneuver::factory() {
  Maneuver maneuver = {};
  maneuver.stroke_count = 4;
  maneuver.speed_cdeg_s = 17000;
  maneuver.strokes[0] = Stroke{1, 5900, 700000};
  maneuver.strokes[1] = Stroke{2, 7000, 1050000};
  maneuver.strokes[2] = Stroke{1, -5900, 1470000};
  maneuver.strokes[3] = Stroke{2, -7000, 1820000};
  return maneuver;
}

bool Maneuver::decode(const uint8_t* bytes, size_t size) {
  if (size != kSize) return false;
  memcpy(this, bytes, kSize);
  return true;
}

uint16_t Maneuver::crc() const {
  const uint8_t* bytes = reinterpret_cast<const uint8_t*>(this);
  const size_t size = kHeadBytes + stroke_count * sizeof(Stroke);
  uint16_t crc = protocol::kCrc16Initial;
  for (size_t i = 0; i < size; ++i) crc = protocol::crc16_update(crc, bytes[i]);
  return crc;
}

uint32_t Maneuver::duration_us(const Stroke& stroke) const {
  // Rounded up: cdeg / (cdeg/s) in microseconds, without 64-bit arithmetic. At most 32768 cdeg and
  // at least 1000 cdeg/s; the millisecond first, then the rest.
  const uint32_t scaled = static_cast<uint32_t>(magnitude(stroke.angle_cdeg)) * 1000;
  const uint32_t whole_ms = scaled / speed_cdeg_s;
  const uint32_t rest = scaled % speed_cdeg_s;
  return whole_ms * 1000 + (rest * 1000 + speed_cdeg_s - 1) / speed_cdeg_s;
}

uint32_t Maneuver::end_us() const {
  const Stroke& last = strokes[stroke_count - 1];
  return last.start_us + duration_us(last);
}

int16_t Maneuver::angle_before(uint8_t stroke_index, uint8_t joint) const {
  int16_t angle_cdeg = 0;
  for (uint8_t i = 0; i < stroke_index; ++i) {
    if (strokes[i].joint == joint)
      angle_cdeg = static_cast<int16_t>(angle_cdeg + strokes[i].angle_cdeg);
  }
  return angle_cdeg;
}

Defect Maneuver::find_defect() const {
  using namespace protocol;
  if (stroke_count == 0 || stroke_count > kMaxStrokes)
    return Defect{ErrorCode::kTooManyStrokes, -1};
  if (speed_cdeg_s < kSpeedMinCdegS || speed_cdeg_s > kSpeedMaxCdegS) {
    return Defect{ErrorCode::kSpeedOutOfRange, -1};
  }
  uint32_t free_from_us = kPauseMinUs;
  for (uint8_t i = 0; i < stroke_count; ++i) {
    const Stroke& stroke = strokes[i];
    if (stroke.joint < 1 || stroke.joint > kJointCount) return Defect{ErrorCode::kJointUnknown, i};
    const int32_t angle = static_cast<int32_t>(angle_before(i, stroke.joint)) + stroke.angle_cdeg;
    if (stroke.angle_cdeg == 0 || angle < static_cast<int32_t>(kJointAngleMinCdeg) ||
        angle > static_cast<int32_t>(kJointAngleMaxCdeg)) {
      return Defect{ErrorCode::kAngleOutOfRange, i};
    }
    if (stroke.start_us < free_from_us) {
      return Defect{i == 0 ? ErrorCode::kTooEarly : ErrorCode::kStrokesOverlap, i};
    }
    if (stroke.start_us > kFallUs) return Defect{ErrorCode::kTooLong, i};
    const uint32_t taken = duration_us(stroke);
    free_from_us = stroke.start_us + (taken > kScheduleGridUs ? taken : kScheduleGridUs);
  }
  if (end_us() > kFallUs) return Defect{ErrorCode::kTooLong, stroke_count - 1};
  return Defect{ErrorCode::kNone, -1};
}

}  // namespace sequencer
}  // namespace tfsat
